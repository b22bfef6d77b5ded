// Snapshots made by hand for the effects' tests: sheets of tissue with a source on them.
#pragma once
#include <cmath>
#include <functional>
#include <numbers>

#include "calot/view/snapshot.h"

namespace calot::test {

/// A sheet over x, y in ±half [m] with `cells`² squares, as high as told.
inline Snapshot sheet_snapshot(float half, int cells, const std::function<float(float, float)>& height,
                               TissueLook look = TissueLook::liver) {
  Snapshot s;
  s.time_step = 0.01;
  s.skin.version = 1;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const float x = half * (2 * static_cast<float>(i) / static_cast<float>(cells) - 1);
      const float y = half * (2 * static_cast<float>(j) / static_cast<float>(cells) - 1);
      SkinVertex v;
      v.vertex = static_cast<std::uint32_t>(s.skin.vertices.size());
      v.rest = Vec3f(x, y, height(x, y));
      v.look = look;
      s.skin.vertices.push_back(v);
      s.positions.push_back(v.rest);
    }
  const auto n = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t j = 0; j + 1 < n; ++j)
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      s.skin.triangles.push_back({a, b, d});
      s.skin.triangles.push_back({a, d, c});
    }
  s.conditions.resize(s.positions.size());
  return s;
}

/// A plane that falls towards +x by `angle` [rad].
inline Snapshot incline(float angle, int cells = 40, float half = 0.05F) {
  return sheet_snapshot(half, cells, [=](float x, float) { return -std::tan(angle) * x; });
}

/// The triangle nearest to a place, as a fluid's.
inline void put_source(Snapshot& s, std::uint32_t id, Fluid fluid, const Vec3f& near) {
  FluidSnapshot f;
  f.id = id;
  f.fluid = fluid;
  float least = 1e30F;
  for (const Triangle& t : s.skin.triangles) {
    const Vec3f middle = (s.positions[t[0]] + s.positions[t[1]] + s.positions[t[2]]) / 3.0F;
    if (!((middle - near).norm() < least)) continue;
    least = (middle - near).norm();
    f.position = middle;
    f.triangle = t;
  }
  s.fluids.push_back(f);
}

/// A step on, in which sources shed at `rate` [m³/s].
inline void next_step(Snapshot& s, double rate) {
  ++s.step;
  s.time += s.time_step;
  for (FluidSnapshot& f : s.fluids) {
    f.rate = rate;
    f.shed += rate * s.time_step;
  }
}

}  // namespace calot::test
