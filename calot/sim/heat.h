// Heat in tissue: cautery, its spread, what it coagulates and what it boils away.
#pragma once
#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calot/mesh/topology_edit.h"
#include "calot/sim/tissue_properties.h"

namespace calot {

/// A hook or forceps with the pedal down, where it touches tissue.
struct HeatSource {
  Vec3 place = Vec3::Zero();  ///< among the current positions [m]
  double radius = 1.5e-3;     ///< of the tissue that takes the current, > 0 [m]
  double power = 30;          ///< set at the generator, ≥ 0; usually 20 … 55 [W]
  double efficiency = 0.5;    ///< share of it that heats tissue, 0 … 1
  double cutting = 0;         ///< share of that which boils the nearest tissue at once, 0 (coagulation) … 1 (cut)
};

struct HeatOptions {
  double body_temperature = 37;  ///< of blood, of tissue at the start, and of the gas [°C]
  double surface_exchange = 10;  ///< to the gas around, ≥ 0 [W/(m² K)]
  double threshold = 0.005;      ///< a tet conducts once a corner is this much off body temperature, > 0 [K]
  double damage_from = 43;       ///< no coagulation below [°C]
  int stiffness_levels = 4;      ///< steps in which the stiffness rises, ≥ 1
};

/// Where the energy went since the start [J]: supplied = stored() + perfused + exchanged + removed − reshaped.
struct HeatLedger {
  double supplied = 0;   ///< by sources
  double perfused = 0;   ///< carried away by blood
  double exchanged = 0;  ///< to the gas
  double removed = 0;    ///< in tissue that was removed
  double reshaped = 0;   ///< gained by the mesh's reshaping, when vertices move to other rest positions
};

struct HeatStep {
  double delivered = 0;  ///< power that tissue took: less than set once all that is touched is dry [W]
  double hottest = 0;    ///< [°C], body temperature where nothing is hot
  std::size_t active_tets = 0;
  int iterations = 0;
  double residual = 0;           ///< of the linear system, relative
  std::vector<TetId> stiffened;  ///< whose stiffness factor changed in this step, ascending
  std::vector<TetId> vaporised;  ///< dried out: to be removed, ascending; listed in each step until they are
};

namespace detail {
struct HeatedTet {
  TetId tet;
  std::array<double, 4> share{};  ///< of the power, to the tet's corners; all shares of a source together are 1
  double distance = 0;            ///< from the source to the tet's middle [m]
  double rest = 0;                ///< of its energy, once its corners boil [J]
};
}  // namespace detail

/// Pennes' bio-heat equation on P1 tets in their rest shape, lumped, implicit Euler. Source: [Pennes1948];
/// docs/simulation.md. One thread; the work is linear in the tets that are hot, none when none is.
class TissueHeat {
 public:
  TissueHeat() = default;
  /// Throws InputError for a region without properties and for figures out of range.
  TissueHeat(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
             const HeatOptions& options = {});

  /// One step of `dt` > 0 [s]. `mesh` is the one of the last edit, `positions` where its vertices are now (n).
  const HeatStep& step(double dt, std::span<const HeatSource> sources, const TetMesh& mesh,
                       std::span<const Vec3> positions);
  /// Brings everything up to date after an edit; `mesh` and `around` are those after it.
  void follow(const Remap& remap, const TetMesh& mesh, const VertexTets& around);

  [[nodiscard]] double temperature(VertexId v) const { return options_.body_temperature + excess_[v.index()]; }
  /// Sets the temperature of a vertex [°C], as an initial condition; the energy counts as supplied.
  void set_temperature(VertexId v, double celsius);
  [[nodiscard]] std::span<const double> peak_temperatures() const { return peak_; }  ///< n [°C]
  [[nodiscard]] std::span<const double> thermal_dose() const { return dose_; }       ///< n, CEM43 [min]
  [[nodiscard]] std::span<const double> coagulation() const { return coagulated_; }  ///< n, 0 … 1
  [[nodiscard]] std::span<const double> charring() const { return charred_; }        ///< n, 0 … 1, how dry
  [[nodiscard]] double stiffness_factor(TetId tet) const;                            ///< ≥ 1
  [[nodiscard]] double stored() const;                                               ///< energy in the tissue [J]
  [[nodiscard]] const HeatLedger& ledger() const { return ledger_; }
  [[nodiscard]] const HeatOptions& options() const { return options_; }
  void append_state(std::string& bytes) const;

 private:
  struct Element {                   // of a tet, at rest
    std::array<double, 6> exchange;  // between its corners, edges 01 02 03 12 13 23 [W/K]
    double volume = 0;               // [m³]
    std::array<double, 4> surface;   // a third of the boundary faces' area at each corner [m²]
    std::uint8_t kind = 0;           // in kinds_
  };
  struct Vertex {                                      // sums over its tets
    double capacity = 0, perfusion = 0, exchange = 0;  // [J/K], [W/K], [W/K]
    double boiling = 0;                                // above body temperature [K]
    std::uint8_t kind = 0;                             // of most of its volume
  };
  [[nodiscard]] Element element(const TetMesh& mesh, TetId tet) const;
  void measure_surface(const TetMesh& mesh, TetId tet);
  void sum_vertices(const TetMesh& mesh);
  [[nodiscard]] double heated_to(std::size_t v) const { return excess_[v] + heating_[v] / vertices_[v].capacity; }
  [[nodiscard]] double dry_energy(TetId tet, const Tet& corners) const;
  [[nodiscard]] double corner_energy(TetId tet, const Tet& corners) const;
  void place_sources(double dt, std::span<const HeatSource> sources, const TetMesh& mesh,
                     std::span<const Vec3> positions);
  double warm(const TetMesh& mesh, double energy);
  double cut_into(const TetMesh& mesh, double energy);
  void activate(const TetMesh& mesh, VertexId v);
  void settle_active(const TetMesh& mesh);
  void multiply(const TetMesh& mesh, double dt, const std::vector<double>& x, std::vector<double>& y) const;
  void prepare(const TetMesh& mesh, double dt);
  void solve(const TetMesh& mesh, double dt);
  void conduct(const TetMesh& mesh, double dt);
  void warm_undercooled(const TetMesh& mesh, double coldest);
  void boil(const TetMesh& mesh);
  void harm(const TetMesh& mesh, double dt);
  [[nodiscard]] double energy_leaving(const Remap& remap) const;
  void carry_tets(const Remap& remap, const TetMesh& mesh);
  void measure_again(const Remap& remap, const TetMesh& mesh);
  void carry_vertices(const Remap& remap, const TetMesh& mesh);

  HeatOptions options_;
  std::vector<TissueProperties> kinds_;
  std::map<std::int32_t, std::uint8_t> kind_of_region_;
  VertexTets around_;
  std::vector<Element> elements_;  // m
  std::vector<Vertex> vertices_;   // n

  std::vector<double> excess_;                                       // n, above body temperature [K]
  std::vector<double> peak_, dose_, damage_, coagulated_, charred_;  // n
  std::vector<double> dried_;                                        // m, energy that went into boiling [J]
  std::vector<std::uint8_t> level_;                                  // m, of stiffness
  std::vector<std::uint8_t> hot_;                                    // n, whose tets conduct
  std::vector<std::uint32_t> active_tets_, active_vertices_;         // ascending
  HeatLedger ledger_;
  std::uint64_t steps_ = 0;

  HeatStep report_;  // and what a step needs, kept so that it doesn't allocate
  std::vector<double> heating_ /* [J] */, solution_, residual_, direction_, product_, diagonal_, inverse_, conductance_;
  std::vector<std::uint8_t> tet_is_active_, vertex_is_active_, harmed_;
  std::vector<std::uint32_t> neighbours_;
  std::vector<detail::HeatedTet> heated_;
};

}  // namespace calot
