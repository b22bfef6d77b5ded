#include "calot/compliance/float_factor.h"

namespace calot {

FloatFactor::FloatFactor(const SparseFactor& factor)
    : pattern_(factor.shared_pattern()), values_(Buffer::recycled((pattern_->panel_start.back() + 1) / 2)) {
  auto* const values = reinterpret_cast<float*>(values_.data());
  for (std::size_t s = 0; s < pattern_->supernodes(); ++s) {
    const std::size_t own = 3 * pattern_->own(s), ld = own + 3 * pattern_->below(s);
    const double* from = factor.panel(s);
    float* to = values + pattern_->panel_start[s];
    for (std::size_t k = 0; k < own * ld; ++k) to[k] = static_cast<float>(from[k]);
  }
}

}  // namespace calot
