// Inside this room only: raw bytes of a class's changing state, for the world's state hash.
#pragma once
#include <string>
#include <type_traits>

#include "calot/contact/rigid_shape.h"

namespace calot::detail {

template <class T>
requires std::is_arithmetic_v<T> || std::is_enum_v<T>
void append_bytes(std::string& bytes, T value) {
  if constexpr (std::is_floating_point_v<T>) value += T(0);  // −0 and 0 are the same state
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline void append_bytes(std::string& bytes, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) append_bytes(bytes, v[axis]);
}

inline void append_bytes(std::string& bytes, const Pose& pose) {
  for (int k = 0; k < 4; ++k) append_bytes(bytes, pose.rotation.coeffs()[k]);
  append_bytes(bytes, pose.position);
}

}  // namespace calot::detail
