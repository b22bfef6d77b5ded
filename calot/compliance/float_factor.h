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

  [[nodiscard]] const float* panel(std::size_t s) const { return values_.data() + pattern_->panel_start[s]; }

 private:
  std::shared_ptr<const FactorPattern> pattern_;
  std::vector<float> values_;    // panels as in SparseFactor
  std::vector<float> inverted_;  // 1 / diagonal, in the order of the factor
};

}  // namespace calot
