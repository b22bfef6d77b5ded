// A sparse factor in single precision, for preconditioning and contact: half the memory to walk through, wider
// registers.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "calot/compliance/sparse_factor.h"

namespace calot {

/// Solves with a rounded copy of a SparseFactor; relative error about 1e-7 times the condition number. Vectors have
/// 3n rows in the factor's order. One thread; the bits never vary.
class FloatFactor {
 public:
  FloatFactor() = default;
  explicit FloatFactor(const SparseFactor& factor);

  [[nodiscard]] std::size_t size() const { return 3 * pattern_->vertices(); }
  [[nodiscard]] const FactorPattern& pattern() const { return *pattern_; }

  /// x ← L⁻¹ x and x ← L⁻ᵀ x; `work` is grown once.
  void forward(float* x, std::vector<float>& work) const;
  void backward(float* x, std::vector<float>& work) const;

  /// Sixteen right-hand sides at once, x[16·row + lane] ← L⁻¹ x. Only supernodes on the paths of those in `starts` (any
  /// order) to the roots are entered: every non-zero of x must belong to one of them. `path` gets those supernodes,
  /// ascending; rows of x elsewhere are left as they are.
  static constexpr std::size_t lanes = 16;
  void forward_many(float* x, std::span<const std::uint32_t> starts, std::vector<std::uint32_t>& path,
                    std::vector<float>& work) const;

 private:
  std::shared_ptr<const FactorPattern> pattern_;
  std::vector<float> values_;  // panels as in SparseFactor, the diagonal inverted
};

}  // namespace calot
