#include <gtest/gtest.h>

#include "calot/base/files.h"
#include "calot/base/parallel.h"
#include "tests/support/accuracy.h"

namespace calot {
namespace {

// Everything that comes out of a run with cuts and folds, as bytes.
std::string state_hash(Backend backend, int threads) {
  const int before = thread_count();
  set_thread_count(threads);
  Model model = test::biliary_model(0.02);
  Compliance compliance = precompute(model, {backend});
  std::string bytes;
  const auto note = [&](const Eigen::MatrixXd& m) {
    bytes.append(reinterpret_cast<const char*>(m.data()), static_cast<std::size_t>(m.size()) * sizeof(double));
  };
  for (std::uint64_t step = 1; step <= 6; ++step) {
    compliance.update(model.apply({test::random_tets(model.mesh(), 12, step), {}, {}}));
    if (step == 2) compliance.start_fold();
    if (step == 4) compliance.adopt_fold();
    const std::vector<DofId> dofs = test::sample_dofs(model.mesh().vertex_count());
    note(compliance.block(dofs, dofs));
    note(compliance.columns(dofs));
  }
  set_thread_count(before);
  return sha256(bytes);
}

TEST(Threads, SameBitsOnAnyNumberOfThem) {
  for (const Backend backend : {Backend::dense, Backend::sparse}) {
    const std::string one = state_hash(backend, 1);
    RecordProperty(backend == Backend::dense ? "dense" : "sparse",
                   one);  // to compare builds by: debug, release, sanitized
    EXPECT_EQ(state_hash(backend, 2), one);
    EXPECT_EQ(state_hash(backend, 4), one);
  }
}

}  // namespace
}  // namespace calot
