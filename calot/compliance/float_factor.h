// A sparse factor in single precision, for preconditioning and contact: half the memory to walk through, wider
// registers.
#pragma once
#include <memory>

#include "calot/compliance/sparse_factor.h"

namespace calot {

/// A rounded copy of a SparseFactor: what it solves has a relative error of about 1e-7 times the condition number.
class FloatFactor {
 public:
  FloatFactor() = default;
  explicit FloatFactor(const SparseFactor& factor);

  [[nodiscard]] std::size_t size() const { return 3 * pattern_->vertices(); }
  [[nodiscard]] const FactorPattern& pattern() const { return *pattern_; }
  [[nodiscard]] const float* panel(std::size_t s) const { return values() + pattern_->panel_start[s]; }

 private:
  std::shared_ptr<const FactorPattern> pattern_;
  [[nodiscard]] const float* values() const { return reinterpret_cast<const float*>(values_.data()); }
  Buffer values_;  // panels as in SparseFactor, two numbers in the room of one
};

}  // namespace calot
