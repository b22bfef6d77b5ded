// The models are closed, look outwards, and lie where the simulation feels the instruments.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "calot/view/models/model.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

constexpr std::array kinds{InstrumentKind::bowel_grasper, InstrumentKind::curved_forceps, InstrumentKind::clip_applier,
                           InstrumentKind::scissors,      InstrumentKind::hook,           InstrumentKind::suction,
                           InstrumentKind::fan_retractor};

/// The part with doubled vertices joined again.
Surface welded(const ModelPart& part) {
  Surface surface;
  std::map<std::array<float, 3>, std::uint32_t> known;
  std::vector<std::uint32_t> now;
  for (const Vec3f& p : part.positions) {
    const auto [at, added] = known.try_emplace({p.x(), p.y(), p.z()}, surface.positions.size());
    if (added) surface.positions.push_back(p.cast<double>());
    now.push_back(at->second);
  }
  for (const Triangle& t : part.triangles) surface.triangles.push_back({now[t[0]], now[t[1]], now[t[2]]});
  return surface;
}

/// Volume of each closed piece.
std::vector<double> volumes(const Surface& surface) {
  std::vector<std::uint32_t> leader(surface.positions.size());
  for (std::uint32_t k = 0; k < leader.size(); ++k) leader[k] = k;
  const auto find = [&](std::uint32_t v) {
    while (leader[v] != v) v = leader[v] = leader[leader[v]];
    return v;
  };
  for (const Triangle& t : surface.triangles)
    for (const std::uint32_t v : t) leader[find(v)] = find(t[0]);
  std::map<std::uint32_t, double> sums;
  for (const Triangle& t : surface.triangles)
    sums[find(t[0])] += surface.positions[t[0]].dot(surface.positions[t[1]].cross(surface.positions[t[2]])) / 6;
  std::vector<double> out;
  for (const auto& [piece, volume] : sums) out.push_back(volume);
  return out;
}

double segment_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double share = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0;
  return (p - a - share * ab).norm();
}

double triangle_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double square = normal.squaredNorm();
  if (square > 0) {
    const double u = (c - b).cross(p - b).dot(normal), v = (a - c).cross(p - c).dot(normal),
                 w = (b - a).cross(p - a).dot(normal);
    if (u >= 0 && v >= 0 && w >= 0) return std::abs((p - a).dot(normal)) / std::sqrt(square);
  }
  return std::min({segment_distance(p, a, b), segment_distance(p, b, c), segment_distance(p, c, a)});
}

/// Signed: negative inside.
double shape_distance(const RigidShape& shape, const Vec3& p) {
  double least = INFINITY;
  for (const RoundedPiece& piece : shape.pieces) {
    const auto& c = piece.corners;
    const double core = piece.corner_count == 1   ? (p - c[0]).norm()
                        : piece.corner_count == 2 ? segment_distance(p, c[0], c[1])
                                                  : triangle_distance(p, c[0], c[1], c[2]);
    least = std::min(least, core - piece.radius);
  }
  return least;
}

double model_distance(const std::vector<const ModelPart*>& parts, const Vec3& p) {
  double least = INFINITY;
  for (const ModelPart* part : parts)
    for (const Triangle& t : part->triangles) {
      const Vec3 a = part->positions[t[0]].cast<double>(), b = part->positions[t[1]].cast<double>(),
                 c = part->positions[t[2]].cast<double>();
      const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
      if ((p - p.cwiseMax(low).cwiseMin(high)).norm() >= least) continue;  // beyond its box
      least = std::min(least, triangle_distance(p, a, b, c));
    }
  return least;
}

/// Points on the outside of a shape: along each piece's edges, in rings about them.
std::vector<Vec3> points_on(const RigidShape& shape, const RigidShape& all) {
  std::vector<Vec3> points;
  for (const RoundedPiece& piece : shape.pieces)
    for (int e = 0; e < (piece.corner_count == 3 ? 3 : 1); ++e) {
      const Vec3 &a = piece.corners[static_cast<std::size_t>(e)],
                 &b = piece.corners[static_cast<std::size_t>((e + 1) % 3)];
      const Vec3 along = (b - a).normalized(), side = along.unitOrthogonal(), other = along.cross(side);
      const double length = (b - a).norm();
      for (double s = -piece.radius; s <= length + piece.radius; s += 0.9 * mm)
        for (int k = 0; k < 8; ++k) {
          const double angle = std::numbers::pi * k / 4, over = s < 0 ? s : s > length ? s - length : 0;
          const double r = std::sqrt(std::max(0.0, piece.radius * piece.radius - over * over));
          const Vec3 p = a + s * along + r * (std::cos(angle) * side + std::sin(angle) * other);
          if (shape_distance(all, p) > -1e-9) points.push_back(p);
        }
    }
  return points;
}

RigidShape together(const InstrumentGeometry& g) {
  RigidShape all = g.shaft;
  for (const RigidShape* jaw : {&g.jaw_a, &g.jaw_b})
    all.pieces.insert(all.pieces.end(), jaw->pieces.begin(), jaw->pieces.end());
  return all;
}

class Models : public testing::TestWithParam<InstrumentKind> {
 protected:
  const InstrumentGeometry geometry_ = instrument_geometry(GetParam());
  const std::vector<ModelPart> parts_ = instrument_model(geometry_);
};

void expect_sound(const ModelPart& part, const std::string& name) {
  const Surface surface = welded(part);
  const ManifoldReport report = check_manifold(surface);
  EXPECT_TRUE(report.closed_manifold()) << name << ": " << report.boundary_edges << " open edges, "
                                        << report.nonmanifold_edges << " shared by more than two, "
                                        << report.nonmanifold_vertices << " vertices";
  for (const double volume : volumes(surface)) EXPECT_GT(volume, 0.01e-9) << name;
  ASSERT_EQ(part.normals.size(), part.positions.size());
  ASSERT_EQ(part.grains.size(), part.positions.size());
  ASSERT_EQ(part.openness.size(), part.positions.size());
  for (std::size_t k = 0; k < part.normals.size(); ++k) {
    ASSERT_NEAR(part.normals[k].norm(), 1, 1e-5) << name;
    ASSERT_NEAR(part.grains[k].norm(), 1, 1e-5) << name;
    ASSERT_NEAR(part.grains[k].dot(part.normals[k]), 0, 1e-5) << name;
    ASSERT_TRUE(part.openness[k] > 0 && part.openness[k] <= 1) << name;
  }
  for (const Triangle& t : part.triangles) {
    const Vec3f& a = part.positions[t[0]];
    const Vec3f face = (part.positions[t[1]] - a).cross(part.positions[t[2]] - a);
    ASSERT_GT(face.norm(), 0) << name << " near " << (1e3F * a).transpose();
    for (const std::uint32_t v : t)
      ASSERT_GT(part.normals[v].dot(face.normalized()), 0.5) << name << " near " << (1e3F * a).transpose() << " mm";
  }
}

TEST_P(Models, AreClosedAndLookOutwards) {
  for (const ModelPart& part : parts_)
    expect_sound(part, std::string(name_of(GetParam())) + ", part of frame " +
                           std::to_string(static_cast<int>(part.frame)) + ", material " +
                           std::to_string(static_cast<int>(part.material)));
}

TEST_P(Models, HaveFewTriangles) {
  std::size_t count = 0;
  for (const ModelPart& part : parts_) count += part.triangles.size();
  EXPECT_LE(count, 15000U);
  EXPECT_GE(count, 500U);
  RecordProperty("triangles", static_cast<int>(count));
}

TEST_P(Models, LieOnTheShapesThatTheSimulationFeels) {
  const RigidShape all = together(geometry_);
  double jaws = 0, joint = 0;
  Vec3 worst = Vec3::Zero();
  for (const ModelPart& part : parts_)
    for (std::size_t k = 0; k < part.positions.size(); ++k) {
      if (part.openness[k] < 0.7F && geometry_.kind == InstrumentKind::suction) continue;  // its bore
      const Vec3 p = part.positions[k].cast<double>();
      const double away = shape_distance(all, p);
      const bool at_joint =
          geometry_.has_jaws() && p.z() > geometry_.shaft.pieces[0].corners[1].z() - 1 * mm && p.z() < 1.7 * mm;
      if (at_joint) {
        joint = std::max(joint, away);  // what is inside is out of sight
      } else if (part.frame != ModelFrame::shaft || geometry_.jaw_length == 0) {
        // Pieces may begin inside others.
        if (away > jaws) worst = p, jaws = away;
      }
    }
  EXPECT_LE(jaws, 0.3 * mm) << (worst / mm).transpose();
  EXPECT_LE(joint, 0.8 * mm);
}

TEST_P(Models, CoverTheShapesThatTheSimulationFeels) {
  const RigidShape all = together(geometry_);
  std::vector<const ModelPart*> parts;
  for (const ModelPart& part : parts_)
    if (part.frame != ModelFrame::shaft || !geometry_.has_jaws()) parts.push_back(&part);
  std::vector<Vec3> points;
  if (geometry_.has_jaws()) {
    points = points_on(geometry_.jaw_a, all);
    const std::vector<Vec3> more = points_on(geometry_.jaw_b, all);
    points.insert(points.end(), more.begin(), more.end());
  } else {
    points = points_on(geometry_.shaft, all);
  }
  double farthest = 0;
  Vec3 worst = Vec3::Zero();
  std::size_t looked_at = 0;
  for (const Vec3& p : points) {
    if (geometry_.has_jaws() && p.z() < 1.7 * mm) continue;                                    // the joint
    if (p.z() < -70 * mm) continue;                                                            // the tube, as before
    if (geometry_.kind == InstrumentKind::suction && p.head<2>().norm() < 1.5 * mm) continue;  // its mouth
    if (geometry_.kind == InstrumentKind::fan_retractor && p.z() < -59 * mm) continue;  // where fingers are joined
    const double away = model_distance(parts, p);
    ++looked_at;
    if (away > farthest) farthest = away, worst = p;
  }
  EXPECT_GT(looked_at, 100U);
  EXPECT_LE(farthest, 0.3 * mm) << (worst / mm).transpose();
}

/// A clip with legs this far apart.
ClipSnapshot clip_with_gap(double gap) {
  ClipSnapshot clip;
  const double radius = 0.5 * mm, y = gap / 2 + radius, half = 4.25 * mm;
  const Vec3 a0(0, -y, -half), a1(0, -y, half), b0(0, y, -half), b1(0, y, half);
  clip.shape.pieces = {{{a0, a1, a1}, 2, radius}, {{b0, b1, b1}, 2, radius}, {{a0, b0, b0}, 2, radius}};
  return clip;
}

TEST(ClipModels, LieOnTheClipsShapeWhileItCloses) {
  for (const double gap : {0.8 * mm, 1.4 * mm, 3 * mm, 6 * mm}) {
    const ClipSnapshot clip = clip_with_gap(gap);
    const ModelPart part = clip_model(clip);
    expect_sound(part, "clip");
    EXPECT_EQ(part.material, ModelMaterial::titanium);
    for (const Vec3f& p : part.positions)
      EXPECT_LE(std::abs(shape_distance(clip.shape, p.cast<double>())), 0.5 * mm) << p.transpose();
    double farthest = 0, out = 0;
    for (const Vec3& p : points_on(clip.shape, clip.shape)) farthest = std::max(farthest, model_distance({&part}, p));
    for (const Vec3f& p : part.positions) out = std::max(out, shape_distance(clip.shape, p.cast<double>()));
    EXPECT_LE(farthest, 0.3 * mm) << gap;
    EXPECT_LE(out, 0.3 * mm) << gap;
  }
}

TEST(ClipModels, ALoadedClipLiesBetweenTheJaws) {
  const InstrumentGeometry applier = instrument_geometry(InstrumentKind::clip_applier);
  for (const double share : {0.25, 0.6, 1.0}) {
    const double opening = share * applier.max_opening;
    const ModelPart part = loaded_clip_model(applier, opening);
    expect_sound(part, "loaded clip");
    const Pose jaw_a = articulate(applier, opening).jaw_a.inverse(),
               jaw_b = articulate(applier, opening).jaw_b.inverse();
    for (const Vec3f& position : part.positions) {
      const Vec3 p = position.cast<double>();
      EXPECT_LE(p.z(), applier.jaw_length);
      EXPECT_GE((jaw_a * p).y(), -0.29 * mm);  // no deeper than the channel
      EXPECT_LE((jaw_b * p).y(), 0.29 * mm);
    }
  }
}

TEST(ClipModels, AnApplierShowsItsNextClipOnceItIsAwayFromTheLast) {
  Snapshot snapshot;
  snapshot.instruments.resize(2);
  snapshot.instruments[0].kind = InstrumentKind::clip_applier;
  snapshot.instruments[0].opening = 0.3;
  snapshot.instruments[1].opening = 0.3;
  EXPECT_TRUE(shows_loaded_clip(snapshot, 0));
  EXPECT_FALSE(shows_loaded_clip(snapshot, 1)) << "a grasper has none";
  snapshot.clips.push_back(clip_with_gap(1 * mm));
  snapshot.clips[0].frame.position = snapshot.instruments[0].pose * Vec3(0, 0, 13 * mm);
  EXPECT_FALSE(shows_loaded_clip(snapshot, 0));
  snapshot.clips[0].frame.position.x() += 12 * mm;
  EXPECT_TRUE(shows_loaded_clip(snapshot, 0));
  snapshot.instruments[0].opening = 0.02;
  EXPECT_FALSE(shows_loaded_clip(snapshot, 0));
}

std::string parameter_name(const testing::TestParamInfo<InstrumentKind>& info) {
  std::string name(name_of(info.param));
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Kinds, Models, testing::ValuesIn(kinds), parameter_name);

}  // namespace
}  // namespace calot
