// Taking a correction into the matrix.
#pragma once
#include "calot/compliance/correction.h"

namespace calot {

/// A dense base with C0 + C0_:T M C0_T: written into `into` (N×N, any content; allocated when empty).
/// @param group  N, connected group of each row; blocks between different groups come out exactly zero, as do the rows of
///               group `no_group` (struck rows)
std::unique_ptr<DenseBase> fold_dense(const DenseBase& base, const Correction& correction, const std::vector<std::uint32_t>& group,
                                      Buffer into);

inline constexpr std::uint32_t no_group = ~0u;

}  // namespace calot
