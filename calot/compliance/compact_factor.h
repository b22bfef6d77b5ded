// A sparse factor in 16-bit numbers, for preconditioning alone: a quarter of the memory to walk through.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "calot/compliance/sparse_factor.h"

namespace calot {

/// A rounded copy of a SparseFactor. Of each column what lies below the vertex's own 3×3 block is kept in multiples of
/// 1/32767 of its largest entry; the blocks on the diagonal are in single precision. What it solves is Â's inverse to a
/// few thousandths; as a preconditioner it costs no iteration more (docs/performance.md).
class CompactFactor {
 public:
  static constexpr std::size_t slack = 16;
  CompactFactor() = default;
  explicit CompactFactor(const SparseFactor& factor);

  [[nodiscard]] std::size_t size() const { return 3 * pattern_->vertices(); }
  [[nodiscard]] const FactorPattern& pattern() const { return *pattern_; }

  /// One supernode of x ← L⁻¹ x; `work`: as many as its rows, and `slack`.
  void eliminate(std::size_t s, float* x, float* work) const;
  /// One supernode of x ← L⁻ᵀ x; `work`: as many as its rows, and `slack`.
  void substitute(std::size_t s, float* x, float* work) const;

 private:
  struct Diagonal {  // of a vertex: its block, the diagonal inverted
    float inverse[3];
    float below[3];  // entries (1, 0), (2, 0), (2, 1)
    float scale[3];  // of the columns' other entries
  };
  [[nodiscard]] const std::int16_t* panel(std::size_t s) const {
    return reinterpret_cast<const std::int16_t*>(values_.data()) + pattern_->panel_start[s];
  }
  std::shared_ptr<const FactorPattern> pattern_;
  Buffer values_;                   // panels as in SparseFactor, four numbers in the room of one
  std::vector<Diagonal> diagonal_;  // of each vertex, in the factor's order
};

}  // namespace calot
