// What a run of `calot simulate` did, in numbers: gathered step by step, told as text and JSON.
#pragma once
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calot/scene/scene_world.h"

namespace calot {

/// Of many numbers: percentiles of the last 131072, and the largest of all.
class Tally {
 public:
  void add(double value);
  /// The share's percentile, 0 … 1; 0 without numbers.
  [[nodiscard]] double percentile(double share) const;
  [[nodiscard]] double max() const { return max_; }

 private:
  std::vector<double> last_;
  std::size_t next_ = 0;
  double max_ = 0;
};

/// How a run's recording compared with this run.
struct ReplayResult {
  std::string file;
  std::uint64_t checked = 0;     ///< states compared
  std::uint64_t differs_at = 0;  ///< the first step whose state is another; 0: none
  bool end_checked = false;      ///< the recorded end was reached and compared
  [[nodiscard]] bool same() const { return differs_at == 0; }
};

class RunSummary {
 public:
  explicit RunSummary(const World& world);

  /// After each step.
  void step(const World& world);
  /// After the last one.
  void end(const World& world, double wall_seconds);

  [[nodiscard]] std::uint64_t count(EventKind kind) const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] nlohmann::ordered_json json() const;
  [[nodiscard]] const std::string& state_hash() const { return state_hash_; }

 private:
  struct Solver {
    Tally iterations;
    double residual = 0;  // largest
    std::uint64_t failed = 0;
    void add(int iterations, double residual, bool converged);
  };
  struct Instrument {
    std::string name, kind;
    double peak_force = 0, slip = 0;  // [N], [m]
    bool jaws = false;
    std::size_t held = 0;  // vertices, at the end
  };
  void add_instruments(const World& world);
  void add_events(const World& world);
  [[nodiscard]] std::string timing_text() const;
  [[nodiscard]] std::string solver_text() const;
  [[nodiscard]] std::string tissue_text() const;

  std::array<Tally, phase_count> phases_;
  Tally total_, contacts_, nonlinear_;
  Solver free_, response_, friction_;
  std::vector<Instrument> instruments_;
  std::uint64_t steps_ = 0, late_ = 0, ran_away_ = 0, steps_inverted_ = 0;
  double time_step_, wall_ = 0;
  double overlap_ = 0, stretch_ = 1, hottest_ = 0;
  std::size_t touched_ = 0, inverted_ = 0;
  std::map<EventKind, std::uint64_t> events_;
  double vaporised_ = 0;   // tets
  double coagulated_ = 0;  // [m³]
  FluidTotals fluids_;
  struct Shape {
    std::size_t vertices = 0, tets = 0, parts = 0;
    double rest_volume = 0, volume = 0, energy = 0;  // [m³], [J]
  } before_, after_;
  static Shape shape_of(const World& world);
  std::string state_hash_;
};

/// "  1.483 s  grasper: …"
std::string event_text(const WorldEvent& event, double time_step);
nlohmann::ordered_json event_json(const WorldEvent& event, const World& world);

}  // namespace calot
