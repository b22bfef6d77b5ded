// What a picture needs to know of blood, bile, smoke and sparks at one moment: plain values, made by `Effects`.
//
// How to draw it, after the tissue and in this order:
// 1. `mask` on the tissue, sampled (trilinear, clamped) at the fragment's rest position: p → mask.texture_place(p).
//    r blood film, g char and soot, b bile film, a how wet (1: fresh, 0: dry). Old blood is dark: its colour goes from
//    clot to fresh red with `a`. Upload: all of it once, then `mask.dirty_boxes(version of the last upload)`.
// 2. `pools` as one indexed mesh, depth-tested, no depth written: what shines through falls off with `thickness`
//    (Beer–Lambert, 1 − exp(−thickness / 0.15 mm for blood, / 2 mm for bile)), with the gloss of a liquid.
// 3. `drops`: ellipsoids in flight, long axis along `velocity`. `sparks`: short additive streaks from `position` to
//    `position − velocity · 4 ms`, white-yellow to red as `heat` goes from 1 to 0.
// 4. `puffs`: camera-facing soft discs, far ones first, opacity 1 − exp(−depth · e^(−2 d²)) at d radii from the middle.
// 5. `haze`: everything at distance d from the lens is mixed with grey, 1 − exp(−haze · d).
// shaders/particle.glsl and shaders/smoke.glsl have these looks as functions.
#pragma once
#include <cstdint>
#include <vector>

#include "calot/view/effects/mask_volume.h"
#include "calot/view/snapshot.h"

namespace calot {

/// A drop in flight.
struct DropState {
  Vec3f position = Vec3f::Zero();  ///< [m]
  Vec3f velocity = Vec3f::Zero();  ///< [m/s]
  float radius = 0;                ///< of a ball of its volume [m]
  Fluid fluid = Fluid::blood;
};

enum class PuffKind : std::uint8_t { smoke, steam };

struct PuffState {
  Vec3f position = Vec3f::Zero();  ///< [m]
  float radius = 0;                ///< twice the standard deviation of its density [m]
  float depth = 0;                 ///< optical depth through its middle, ≥ 0
  float turn = 0;                  ///< of its texture [rad]
  float seed = 0;                  ///< of its texture, 0 … 1
  PuffKind kind = PuffKind::smoke;
};

struct SparkState {
  Vec3f position = Vec3f::Zero(), velocity = Vec3f::Zero();  ///< [m], [m/s]
  float heat = 0;                                            ///< 1 … 0
};

/// A corner of the pools' mesh.
struct PoolVertex {
  Vec3f position = Vec3f::Zero();  ///< on top of the liquid [m]
  Vec3f normal = Vec3f::UnitZ();   ///< unit
  float thickness = 0;             ///< of the liquid there, 0 at the rim [m]
  float bile = 0;                  ///< 0 blood, 1 bile
  float clot = 0;                  ///< 0 fresh, 1 clotted: darker and duller
};

/// A well, a lens in a hollow, or what hangs under an overhang before it drips.
struct PoolState {
  Vec3f position = Vec3f::Zero();  ///< of its middle, on the surface [m]
  Vec3f normal = Vec3f::UnitZ();   ///< of the surface there, unit
  float radius = 0, depth = 0;     ///< [m]
  float volume = 0;                ///< [m³]
  float clot = 0;                  ///< 0 … 1
  Fluid fluid = Fluid::blood;
};

/// Where a fluid is [m³]; shed = the sum of all others.
struct FluidLedger {
  double shed = 0;     ///< by the sources, since the effects began
  double wells = 0;    ///< at the sources, before it runs off
  double running = 0;  ///< down the surface
  double film = 0;     ///< left behind as a film: what the mask holds
  double pooled = 0;
  double flying = 0;  ///< in drops
  double gone = 0;    ///< fell out of the scene
  double sucked = 0;
  [[nodiscard]] double accounted() const { return wells + running + film + pooled + flying + gone + sucked; }
};

struct EffectsState {
  std::uint64_t step = 0;  ///< of the last snapshot
  MaskVolume mask;
  std::vector<DropState> drops;
  std::vector<PuffState> puffs;
  std::vector<SparkState> sparks;
  std::vector<PoolState> pools;
  std::vector<PoolVertex> pool_vertices;    ///< of all pools
  std::vector<std::uint32_t> pool_indices;  ///< triangles, counter-clockwise from outside
  float haze = 0;                           ///< extinction of the gas everywhere [1/m]
  FluidLedger blood, bile;
};

}  // namespace calot
