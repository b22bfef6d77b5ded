// Keeps a compliance that fits the tissue: factored anew in the background, followed through edits meanwhile.
#pragma once
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "calot/sim/corotational.h"
#include "calot/sim/warped_compliance.h"

namespace calot {

/// Fixed numbers of steps, never a clock, so that a replay gives the same bits.
struct RefreshOptions {
  int interval = 0;  ///< steps from one start to the next, ≥ latency; 0: as soon as the one before is adopted
  int latency =
      0;  ///< steps from a start until its result is adopted; 0: by what the factor will cost, see `latency_of`
};
/// Steps that a factor of this pattern with so many ready vertices needs in the background of a machine with two cores,
/// measured at 10,000 and 20,000 tets, with a quarter to spare.
int latency_of(const FactorPattern& pattern, std::size_t ready, double time_step);

/// The present compliance and, most of the time, one on its way. A result is adopted at its step whether or not it is
/// there: if it isn't, the step waits, and the time it waited is reported.
class ComplianceRefresh {
 public:
  /// Factors at once, with the springs that hold tissue for good.
  ComplianceRefresh(const Model& model, const Corotational& tissue, std::span<const Spring> springs,
                    const RefreshOptions& options);
  ~ComplianceRefresh();
  ComplianceRefresh(ComplianceRefresh&&) noexcept = default;
  ComplianceRefresh& operator=(ComplianceRefresh&&) noexcept = default;

  /// Adopts what is due at this step. @return seconds waited
  double adopt(std::uint64_t step);
  /// Starts a new one if it is due at this step. `likely`: vertices that an edit may touch soon.
  void start(std::uint64_t step, const Model& model, const Corotational& tissue, std::span<const Spring> springs,
             std::vector<VertexId> likely);
  /// Factors at once, dropping what is under way: for edits so large that taking them in would cost more.
  void rebuild(const Model& model, const Corotational& tissue, std::span<const Spring> springs);
  /// Factors that could not be computed, so far.
  [[nodiscard]] std::size_t failures() const { return failures_; }
  /// Whether `start` would do something at this step.
  [[nodiscard]] bool start_is_due(std::uint64_t step) const;

  void follow(const std::vector<ElementChange>& changes, const Remap& remap);
  void set_springs(std::span<const Spring> springs);
  [[nodiscard]] WarpedCompliance& present() { return *present_; }
  [[nodiscard]] const WarpedCompliance& present() const { return *present_; }

 private:
  using Pairs = std::vector<std::pair<VertexId, VertexId>>;
  RefreshOptions options_;
  std::unique_ptr<WarpedCompliance> present_, next_;
  std::future<std::unique_ptr<WarpedBase>> work_;
  std::vector<std::future<std::unique_ptr<WarpedBase>>> abandoned_;
  std::uint64_t adopt_at_ = 0, start_at_ = 0;
  std::size_t failures_ = 0;
  std::shared_ptr<const BasePattern> pattern_;  // of the mesh as it is and the spring pairs below; or null
  Pairs pairs_, next_pairs_;
  bool pattern_fits_ = true, next_pattern_fits_ = true;  // no vertex or edge came, none went, since it was made
};

}  // namespace calot
