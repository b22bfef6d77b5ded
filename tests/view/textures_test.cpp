// The textures themselves: no seams, the same bytes, and figures that recipes count on.
#include "calot/view/textures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "calot/base/parallel.h"

namespace calot {
namespace {

const TextureBytes& volume() {
  static const TextureBytes texture = make_tissue_volume();
  return texture;
}

const TextureBytes& tile() {
  static const TextureBytes texture = make_vessel_tile();
  return texture;
}

/// A byte at a texel, numbered along three axes.
int at(const TextureBytes& t, const std::array<int, 3>& p, int channel) {
  const auto index = (static_cast<std::size_t>(p[2]) * t.size + p[1]) * static_cast<std::size_t>(t.size) + p[0];
  return t.rgba[4 * index + static_cast<std::size_t>(channel)];
}

struct Step {
  double mean = 0;
  int largest = 0;
};

/// How much neighbours along an axis differ, from layer `from` to the one after it, around the edge.
Step step_between(const TextureBytes& t, int axis, int from, int channel) {
  const std::array<int, 3> extent{t.size, t.size, t.depth};
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Step step;
  for (int i = 0; i < extent[u]; ++i)
    for (int j = 0; j < extent[v]; ++j) {
      std::array<int, 3> p{}, q{};
      p[u] = q[u] = i, p[v] = q[v] = j;
      p[axis] = from, q[axis] = (from + 1) % extent[axis];
      const int d = std::abs(at(t, p, channel) - at(t, q, channel));
      step.mean += d;
      step.largest = std::max(step.largest, d);
    }
  step.mean /= extent[u] * extent[v];
  return step;
}

void expect_no_seam(const TextureBytes& t, int axis, int channel) {
  const int last = (axis < 2 ? t.size : t.depth) - 1;
  Step inside;
  for (int k = 0; k < last; ++k) {
    const Step step = step_between(t, axis, k, channel);
    inside.mean = std::max(inside.mean, step.mean);
    inside.largest = std::max(inside.largest, step.largest);
  }
  const Step seam = step_between(t, axis, last, channel);
  EXPECT_LE(seam.mean, inside.mean * 1.05) << "axis " << axis << ", channel " << channel;
  EXPECT_LE(seam.largest, inside.largest + 8) << "axis " << axis << ", channel " << channel;
  EXPECT_GT(inside.mean, 0.5) << "channel " << channel << " is flat";
}

struct Figures {
  double mean = 0, low = 0, high = 0;  ///< low, high: percentiles 2 and 98
};

Figures figures(const TextureBytes& t, int channel) {
  std::array<std::size_t, 256> count{};
  for (std::size_t k = static_cast<std::size_t>(channel); k < t.rgba.size(); k += 4) ++count[t.rgba[k]];
  const double all = static_cast<double>(t.rgba.size()) / 4;
  Figures f;
  double below = 0;
  for (int v = 0; v < 256; ++v) {
    f.mean += v * static_cast<double>(count[static_cast<std::size_t>(v)]) / all;
    below += static_cast<double>(count[static_cast<std::size_t>(v)]) / all;
    if (below < 0.02) f.low = v + 1;
    if (below < 0.98) f.high = v + 1;
  }
  return f;
}

std::uint64_t hash_of(const std::vector<std::uint8_t>& bytes) {
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
  for (const std::uint8_t b : bytes) hash = (hash ^ b) * 1099511628211ULL;
  return hash;
}

TEST(Textures, AreAsLargeAsTheySay) {
  EXPECT_EQ(volume().size, 128);
  EXPECT_EQ(volume().depth, 128);
  EXPECT_EQ(volume().rgba.size(), 4U * 128 * 128 * 128);
  EXPECT_EQ(tile().size, 512);
  EXPECT_EQ(tile().depth, 1);
  EXPECT_EQ(tile().rgba.size(), 4U * 512 * 512);
}

TEST(Textures, HaveNoSeam) {
  for (int channel = 0; channel < 4; ++channel) {
    for (int axis = 0; axis < 3; ++axis) expect_no_seam(volume(), axis, channel);
    for (int axis = 0; axis < 2; ++axis) expect_no_seam(tile(), axis, channel);
  }
}

TEST(Textures, AreTheSameOnAnyNumberOfThreads) {
  const int before = thread_count();
  set_thread_count(before == 1 ? 2 : 1);
  const TextureBytes again = make_tissue_volume();
  set_thread_count(before);
  EXPECT_TRUE(again.rgba == volume().rgba);
  EXPECT_TRUE(make_vessel_tile().rgba == tile().rgba);
}

TEST(Textures, AreTheSameOnEveryMachine) {
  EXPECT_EQ(hash_of(volume().rgba), 8485014785200862346U);
  EXPECT_EQ(hash_of(tile().rgba), 6049558559967413786U);
}

TEST(Textures, UseTheirRange) {
  for (int channel = 0; channel < 4; ++channel) {
    const Figures f = figures(volume(), channel);
    EXPECT_LT(f.low, 90) << channel;
    EXPECT_GT(f.high, 160) << channel;
  }
  EXPECT_NEAR(figures(volume(), 2).mean, 127.5, 6);  // clouds
  EXPECT_NEAR(figures(tile(), 3).mean, 127.5, 6);    // grain
}

TEST(Textures, VesselsAreSparseAndTheFlushIsSoft) {
  for (const int channel : {0, 1}) {
    const Figures f = figures(tile(), channel);
    EXPECT_GT(f.mean, 1) << channel;
    EXPECT_LT(f.mean, 40) << channel;  // most of the surface has none
    EXPECT_EQ(f.low, 0) << channel;
  }
  int largest = 0;
  for (int k = 0; k < 511; ++k) largest = std::max(largest, step_between(tile(), 0, k, 2).largest);
  EXPECT_LE(largest, 12);
}

}  // namespace
}  // namespace calot
