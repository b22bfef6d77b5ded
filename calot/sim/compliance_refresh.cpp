#include "calot/sim/compliance_refresh.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "calot/base/error.h"
#include "calot/base/parallel.h"

namespace calot {
namespace {

std::vector<std::pair<VertexId, VertexId>> pairs_of(std::span<const Spring> springs) {
  std::vector<std::pair<VertexId, VertexId>> pairs;
  for (const Spring& spring : springs)
    if (spring.other.valid()) pairs.emplace_back(spring.vertex, spring.other);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

// Seen from the pattern: edges may go, but nothing may come and no number may change.
bool keeps_pattern(const Remap& remap) {
  return remap.added_vertices.empty() && remap.added_tets.empty() && remap.orphaned.empty();
}

}  // namespace

int latency_of(const FactorPattern& pattern, std::size_t ready, double time_step) {
  const double seconds = 4e-3 + pattern.flops / 12e9 + 3 * static_cast<double>(ready) * pattern.nonzeros / 6e9;
  return static_cast<int>(std::clamp(std::ceil(1.25 * seconds / time_step), 2.0, 60.0));
}

ComplianceRefresh::ComplianceRefresh(const Model& model, const Corotational& tissue, std::span<const Spring> springs,
                                     const RefreshOptions& options)
    : options_(options) {
  if (options_.interval < 0 || options_.latency < 0)
    throw InputError("refresh", "has an interval or a latency below 0", "leave both at 0");
  pairs_ = pairs_of(springs);
  const BaseRequest request{model, tissue.rotations(), {springs.begin(), springs.end()}, {}, nullptr};
  present_ = std::make_unique<WarpedCompliance>(request);
  present_->set_base(make_base(request));
  pattern_ = present_->base().shared;
}

ComplianceRefresh::~ComplianceRefresh() {
  if (work_.valid()) work_.wait();
  for (const auto& work : abandoned_) work.wait();
}

double ComplianceRefresh::adopt(std::uint64_t step) {
  if (!next_ || step != adopt_at_) return 0;
  const auto begin = std::chrono::steady_clock::now();
  std::unique_ptr<WarpedBase> base;
  try {
    base = work_.get();
  } catch (const Error&) {  // no memory, or an operator that isn't definite: the present one goes on
    next_.reset();
    ++failures_;
    return 0;
  }
  const double waited = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  pattern_ = base->shared;
  pattern_fits_ = next_pattern_fits_;
  pairs_ = std::move(next_pairs_);
  next_->set_base(std::move(base));
  present_ = std::move(next_);
  return waited;
}

void ComplianceRefresh::rebuild(const Model& model, const Corotational& tissue, std::span<const Spring> springs) {
  if (next_) abandoned_.push_back(std::move(work_));
  next_.reset();
  std::erase_if(abandoned_,
                [](const auto& work) { return work.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  const BaseRequest request{model, tissue.rotations(), {springs.begin(), springs.end()}, {}, nullptr};
  present_ = std::make_unique<WarpedCompliance>(request);
  present_->set_base(make_base(request));
  pattern_ = present_->base().shared;
  pairs_ = pairs_of(springs);
  pattern_fits_ = true;
}

bool ComplianceRefresh::start_is_due(std::uint64_t step) const {
  return !next_ && step >= start_at_;
}

void ComplianceRefresh::start(std::uint64_t step, const Model& model, const Corotational& tissue,
                              std::span<const Spring> springs, std::vector<VertexId> likely) {
  if (!start_is_due(step)) return;
  next_pairs_ = pairs_of(springs);
  const bool fits =
      pattern_fits_ && std::includes(pairs_.begin(), pairs_.end(), next_pairs_.begin(), next_pairs_.end());
  if (fits) next_pairs_ = pairs_;
  BaseRequest request{
      model, tissue.rotations(), {springs.begin(), springs.end()}, std::move(likely), fits ? pattern_ : nullptr};
  next_ = std::make_unique<WarpedCompliance>(request);
  next_pattern_fits_ = true;
  const int latency = options_.latency > 0
                          ? options_.latency
                          : latency_of(*pattern_->factor, request.likely.size(), model.dynamics().time_step);
  adopt_at_ = step + static_cast<std::uint64_t>(latency);
  start_at_ = step + static_cast<std::uint64_t>(options_.interval);
  work_ = std::async(std::launch::async, [request = std::move(request)] {
    const BackgroundLane lane(std::max(1, thread_count() / 2));
    return make_base(request);
  });
}

void ComplianceRefresh::follow(const std::vector<ElementChange>& changes, const Remap& remap) {
  present_->follow(changes, remap);
  if (next_) next_->follow(changes, remap);
  if (keeps_pattern(remap)) return;
  pattern_fits_ = next_pattern_fits_ = false;
}

void ComplianceRefresh::set_springs(std::span<const Spring> springs) {
  present_->set_springs(springs);
  if (next_) next_->set_springs(springs);
}

}  // namespace calot
