#include "calot/compliance/compact_factor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calot/compliance/path_solve.h"
#include "tests/support/models.h"

namespace calot {
namespace {

std::vector<std::uint8_t> active_of(const Model& model) {
  std::vector<std::uint8_t> active(model.fixed().size());
  for (std::size_t v = 0; v < active.size(); ++v) active[v] = model.fixed()[v] ? 0 : 1;
  return active;
}

double difference(const std::vector<float>& a, const std::vector<double>& b) {
  double sum = 0, size = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    sum += std::pow(static_cast<double>(a[i]) - b[i], 2);
    size += b[i] * b[i];
  }
  return std::sqrt(sum / size);
}

TEST(CompactFactor, SolvesAsTheFactorToAThousandth) {
  for (const double step : {0.01, 1.0 / 60}) {
    const Model model = test::biliary_model(step);
    const BlockMatrix matrix = model.step_stiffness();
    const std::vector<std::uint8_t> active = active_of(model);
    const SparseFactor exact(std::make_shared<const FactorPattern>(analyse(matrix, active)), matrix, active);
    const CompactFactor compact(exact);
    std::vector<double> x(exact.size()), work;
    std::vector<float> y(exact.size()), short_work;
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = static_cast<float>(x[i] = std::sin(1.7 * static_cast<double>(i)));
    detail::forward_vector(exact, x.data(), work);
    detail::forward_vector(compact, y.data(), short_work);
    EXPECT_LT(difference(y, x), 1e-3);
    EXPECT_GT(difference(y, x), 1e-6);  // else it would not be the compact one
    detail::backward_vector(exact, x.data(), work);
    detail::backward_vector(compact, y.data(), short_work);
    EXPECT_LT(difference(y, x), 1e-3);
  }
}

TEST(CompactFactor, LeavesTheRestOfTheVectorAloneOnAPath) {
  const Model model = test::biliary_model(0.01);
  const BlockMatrix matrix = model.step_stiffness();
  const std::vector<std::uint8_t> active = active_of(model);
  const SparseFactor exact(std::make_shared<const FactorPattern>(analyse(matrix, active)), matrix, active);
  const CompactFactor compact(exact);
  const std::vector<std::uint32_t> path = detail::elimination_path(exact.pattern(), std::vector<std::uint32_t>{0});
  std::vector<float> whole(exact.size(), 0.0F), part(exact.size(), 0.0F), work;
  whole[0] = part[0] = 1;
  detail::forward_vector(compact, whole.data(), work);
  detail::forward_vector(compact, path, part.data(), work);
  EXPECT_EQ(whole, part);
}

}  // namespace
}  // namespace calot
