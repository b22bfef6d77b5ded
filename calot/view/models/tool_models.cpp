// Scissors, hook, suction tube and fan retractor.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calot/view/models/pieces.h"

namespace calot::detail {
namespace {

constexpr double mm = model_mm;
using std::numbers::pi;

// --- scissors ---

/// Blade a: hollow-free and flat towards the other one in x = 0, ground to an edge at y = edge, its back arched.
PlainMesh blade(const InstrumentGeometry& g) {
  constexpr double gap = 0.01 * mm, thick = 0.76 * mm;
  std::vector<Ring> rings;
  const auto add = [&](double z, double top, double low, double outside) {
    const double ground = std::min(0.32 * mm, 0.4 * (top - low)), bevel = std::min(0.3 * mm, 0.25 * (top - low));
    rings.push_back({{-gap, top, z},
                     {-0.12 * outside, top - 0.03 * mm, z},
                     {-outside, top - ground, z},
                     {-outside, low + bevel, z},
                     {-0.6 * outside, low, z},
                     {-gap, low, z}});
  };
  const double tip = g.jaw_length - 0.4 * mm;
  const auto back = [&](double z) {
    const double share = std::clamp(z / tip, 0.0, 1.0);
    const double belly = 0.2 * mm * std::sin(pi * share);
    return g.blade_offset - (g.blade_depth + share * (g.blade_tip_depth - g.blade_depth)) - belly + 0.05 * mm;
  };
  add(-0.35 * mm, g.blade_offset - 0.35 * mm, back(0) + 0.35 * mm, thick);
  add(-0.1 * mm, g.blade_offset - 0.05 * mm, back(0) + 0.05 * mm, thick);
  constexpr int steps = 24;
  for (int k = 1; k <= steps; ++k) {
    const double z = tip * k / steps, share = static_cast<double>(k) / steps;
    add(z, g.blade_offset - 0.06 * mm * share * share, back(z), thick * (1 - 0.1 * share));
  }
  const double top = g.blade_offset - 0.06 * mm, low = back(tip);
  add(tip + 0.2 * mm, top - 0.1 * mm, low + 0.12 * mm, 0.7 * thick);
  add(tip + 0.38 * mm, top - 0.42 * mm, low + 0.36 * mm, 0.5 * thick);
  PlainMesh mesh;
  add_loft(mesh, rings);
  return mesh;
}

/// Half of a screw's head on x, on one side of its slot.
PlainMesh half_head(double radius, double slot, double low, double high) {
  std::vector<Ring> rings;
  for (const auto& [x, share] : {std::pair(low, 1.0), std::pair(high - 0.08 * mm, 1.0), std::pair(high, 0.88)}) {
    Ring ring;
    const double r = radius * share, first = std::asin(slot / r);
    constexpr int steps = 12;
    for (int k = 0; k <= steps; ++k) {
      const double angle = first + (pi - 2 * first) * k / steps;
      ring.emplace_back(x, r * std::cos(angle), r * std::sin(angle));
    }
    rings.push_back(std::move(ring));
  }
  PlainMesh mesh;
  add_loft(mesh, rings);
  return mesh;
}

Vec3 grain_in_yz(const Vec3& p) {
  return {0, -p.z(), p.y()};
}

// --- hook ---

/// A wire that goes round the corner at the heel; the inside of the bend is squeezed together there.
PlainMesh bent_wire(const InstrumentGeometry& g) {
  const double r = 0.985 * g.hook_radius, bend = 0.6 * mm;
  const Outline round = circle(1, 20);
  std::vector<Ring> rings;
  const auto add = [&](const Vec3& at, double angle, double scale, double inside) {
    const Vec3 in = Vec3(0, std::cos(angle), -std::sin(angle));  // towards the inside of the bend
    Ring ring;
    for (const Eigen::Vector2d& p : round)
      ring.push_back(at + scale * p.x() * r * Vec3::UnitX() + std::min(scale * p.y() * r, inside) * in);
    rings.push_back(std::move(ring));
  };
  const Vec3 heel = g.hook_heel, foot = (g.hook_tip - heel).normalized();
  add({0, 0, -1 * mm}, 0, 1, 1);
  add(heel - Vec3(0, 0, bend + 0.3 * mm), 0, 1, 1);
  const Vec3 turn = heel + bend * (foot - Vec3::UnitZ());
  constexpr int steps = 8;
  for (int k = 0; k <= steps; ++k) {
    const double angle = pi / 2 * k / steps;
    add(turn + bend * Vec3(0, -std::cos(angle), std::sin(angle)), angle, 1, 0.97 * bend);
  }
  add(heel + foot * (bend + 0.3 * mm), pi / 2, 1, 1);
  for (int k = 0; k < 6; ++k) {
    const double angle = pi / 2 * k / 6;
    add(g.hook_tip + r * std::sin(angle) * foot, pi / 2, std::cos(angle), 1);
  }
  PlainMesh mesh;
  add_loft(mesh, rings);
  return mesh;
}

// --- suction ---

/// A tube with thick wall as a grid: rings from the far end, outside up to the rim and inside down; holes are blocks
/// of cells left out, whose borders are drawn to a circle.
class PiercedTube {
 public:
  static constexpr int around = 40, block = 4;  // block: cells across a hole
  explicit PiercedTube(const Tube& tube) : tube_(tube), bore_(tube.radius - 0.45 * mm) {}

  PlainMesh build() {
    add_rows();
    for (int k = 0; k < 4; ++k) holes_.push_back({k * around / 4, first_hole});
    for (int k = 0; k < 4; ++k) holes_.push_back({k * around / 4 + around / 8, first_hole + block + 1});
    add_points();
    add_cells(outside_, false);
    add_cells(inside_, true);
    add_rim();
    for (const auto& [column, row] : holes_) add_hole_wall(column, row);
    add_end(outside_.front(), outside_z_.front(), false);
    add_end(inside_.front(), inside_z_.front(), true);
    return std::move(mesh_);
  }

 private:
  static constexpr int first_hole = 2;
  static constexpr double cell = 0.42 * mm;

  void add_rows() {
    const double first = tube_.shoulder - 1.2 * mm - (2 * block + 2) * cell;  // where holes begin
    outside_z_ = {tube_.start, first - cell};
    inside_z_ = {first - 12 * mm, first - cell};
    for (int k = 0; k <= 2 * block + 1; ++k) {
      outside_z_.push_back(first + k * cell);
      inside_z_.push_back(first + k * cell);
    }
    inside_z_.push_back(tube_.shoulder - 0.6 * mm);
    outside_z_.push_back(tube_.shoulder);
  }

  void add_points() {
    for (const double z : outside_z_) outside_.push_back(add_circle(z, tube_.radius, 1));
    for (const double z : inside_z_) inside_.push_back(add_circle(z, bore_, 0.12F));
  }

  std::uint32_t add_circle(double z, double radius, float openness) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    for (int i = 0; i < around; ++i) {
      const Eigen::Vector2d at = bent({i, z});
      mesh_.positions.emplace_back(radius * std::cos(at.x()), radius * std::sin(at.x()), at.y());
      mesh_.openness.push_back(openness);
    }
    return first;
  }

  /// Where a point of the grid lies (angle, z), drawn to the border of a hole if it is on one.
  [[nodiscard]] Eigen::Vector2d bent(const std::pair<int, double>& at) const {
    const double step = 2 * pi / around;
    for (const auto& [column, row] : holes_) {
      const double middle_z = outside_z_[static_cast<std::size_t>(row)] + block / 2.0 * cell;
      const int off = ((at.first - column - block / 2 + around + around / 2) % around) - around / 2;
      const double along = (at.second - middle_z) / cell;
      const double farthest = std::max(std::abs(static_cast<double>(off)), std::abs(along));
      if (std::abs(farthest - block / 2.0) > 1e-6) continue;
      const Eigen::Vector2d way(off * step * tube_.radius, along * cell);
      const Eigen::Vector2d placed = way.normalized() * 0.72 * mm;
      return {step * (column + block / 2) + placed.x() / tube_.radius, middle_z + placed.y()};
    }
    return {step * at.first, at.second};
  }

  [[nodiscard]] bool is_open(int column, int row) const {
    return std::any_of(holes_.begin(), holes_.end(), [&](const auto& hole) {
      const int off = (column - hole.first + around) % around;
      return off < block && row >= hole.second && row < hole.second + block;
    });
  }

  void add_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangles.push_back({a, c, d});
  }

  void add_cells(const std::vector<std::uint32_t>& rows, bool inwards) {
    for (std::size_t row = 0; row + 1 < rows.size(); ++row)
      for (int i = 0; i < around; ++i) {
        if (is_open(i, static_cast<int>(row))) continue;
        const auto here = static_cast<std::uint32_t>(i), next = static_cast<std::uint32_t>((i + 1) % around);
        if (inwards)
          add_quad(rows[row] + next, rows[row] + here, rows[row + 1] + here, rows[row + 1] + next);
        else
          add_quad(rows[row] + here, rows[row] + next, rows[row + 1] + next, rows[row + 1] + here);
      }
  }

  void add_hole_wall(int column, int row) {
    std::vector<std::pair<int, int>> border;  // counter-clockwise seen from outside
    for (int k = 0; k < block; ++k) border.emplace_back(column + k, row);
    for (int k = 0; k < block; ++k) border.emplace_back(column + block, row + k);
    for (int k = block; k > 0; --k) border.emplace_back(column + k, row + block);
    for (int k = block; k > 0; --k) border.emplace_back(column, row + k);
    const auto at = [&](const std::vector<std::uint32_t>& rows, const std::pair<int, int>& place) {
      return rows[static_cast<std::size_t>(place.second)] + static_cast<std::uint32_t>(place.first % around);
    };
    for (std::size_t k = 0; k < border.size(); ++k) {
      const auto& from = border[k];
      const auto& to = border[(k + 1) % border.size()];
      add_quad(at(outside_, from), at(outside_, to), at(inside_, to), at(inside_, from));
    }
  }

  /// From the shoulder round the tip's edge into the bore.
  void add_rim() {
    std::uint32_t below = outside_.back();
    const auto band = [&](double radius, double z, float openness) {
      const std::uint32_t above = add_circle(z, radius, openness);
      join(below, above);
      below = above;
    };
    for (const double angle : {0.25, 0.5, 0.7, 0.85})
      band(tube_.radius * std::cos(angle), tube_.shoulder + tube_.radius * std::sin(angle), 1);
    const double mouth = tube_.radius * std::cos(0.85) - 0.2 * mm;
    band(mouth, tube_.end - 0.68 * mm, 0.6F);
    band(mouth, tube_.end - 1.3 * mm, 0.3F);
    join(below, inside_.back());
  }

  void join(std::uint32_t below, std::uint32_t above) {
    for (std::uint32_t i = 0; i < around; ++i)
      add_quad(below + i, below + (i + 1) % around, above + (i + 1) % around, above + i);
  }

  void add_end(std::uint32_t ring, double z, bool up) {
    const auto centre = static_cast<std::uint32_t>(mesh_.positions.size());
    mesh_.positions.emplace_back(0, 0, z);
    mesh_.openness.push_back(up ? 0.05F : 1.0F);
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = ring + i, b = ring + (i + 1) % around;
      mesh_.triangles.push_back(up ? Triangle{centre, a, b} : Triangle{centre, b, a});
    }
  }

  Tube tube_;
  double bore_;
  std::vector<double> outside_z_, inside_z_;
  std::vector<std::pair<int, int>> holes_;  // first column, first row
  std::vector<std::uint32_t> outside_, inside_;
  PlainMesh mesh_;
};

}  // namespace

Parts scissors_model(const InstrumentGeometry& g) {
  const Tube tube = tube_of(g);
  Parts parts{insulated_tube(tube, tube.shoulder - 3 * mm)};
  constexpr double cheek_in = 0.84 * mm, cheek_out = 1.14 * mm;
  add_clevis(parts, tube, tube.shoulder - 3.3 * mm, cheek_in, cheek_out);
  PlainMesh a = blade(g);
  add_eye(a, 1.2 * mm, -0.78 * mm, -0.01 * mm);
  const PlainMesh b = half_turned(a);
  parts.push_back(finish(a, ModelFrame::jaw_a, ModelMaterial::polished_steel, 0.35, grain_along_z));
  parts.push_back(finish(b, ModelFrame::jaw_b, ModelMaterial::polished_steel, 0.35, grain_along_z));
  PlainMesh head = half_head(0.85 * mm, 0.12 * mm, cheek_out - 0.02 * mm, cheek_out + 0.22 * mm);
  PlainMesh other = head;  // turned about x
  for (Vec3& p : other.positions) p = Vec3(p.x(), -p.y(), -p.z());
  append(head, other);
  append(head, half_turned(head));
  parts.push_back(finish(head, ModelFrame::shaft, ModelMaterial::polished_steel, usual_crease, grain_in_yz));
  return parts;
}

Parts hook_model(const InstrumentGeometry& g) {
  const Tube tube = tube_of(g);
  const double r = tube.radius, s = tube.shoulder;
  Parts parts{insulated_tube(tube, s - 3.5 * mm)};
  // Ceramic takes the arc's heat where the wire comes out; its end is bevelled twice.
  const std::vector<Turned> collar{{0.88 * r, s - 3.8 * mm}, {0.93 * r, s - 3.6 * mm}, {0.95 * r, s - 3.3 * mm},
                                   {0.97 * r, s - 0.2 * mm}, {0.96 * r, s + 0.1 * r},  {0.88 * r, s + 0.47 * r},
                                   {0.64 * r, s + 0.76 * r}, {0.40 * r, s + 0.89 * r}, {0.34 * r, s + 0.9 * r}};
  PlainMesh ceramic;
  add_turned(ceramic, collar, Vec3::Zero(), Vec3::UnitZ(), 48);
  parts.push_back(finish(ceramic, ModelFrame::shaft, ModelMaterial::ceramic, 0.5, grain_round_z));
  parts.push_back(finish(bent_wire(g), ModelFrame::shaft, ModelMaterial::polished_steel, usual_crease, grain_along_z));
  return parts;
}

Parts suction_model(const InstrumentGeometry& g) {
  return {finish(PiercedTube(tube_of(g)).build(), ModelFrame::shaft, ModelMaterial::brushed_steel, usual_crease,
                 grain_round_z)};
}

Parts fan_retractor_model(const InstrumentGeometry& g) {
  const Tube tube = tube_of(g);
  Parts parts{insulated_tube(tube, tube.shoulder - 4 * mm)};
  const double r = tube.radius, s = tube.shoulder;
  const std::vector<Turned> body{{0.9 * r, s - 4.5 * mm}, {0.95 * r, s - 4.2 * mm}, {0.96 * r, s},
                                 {0.9 * r, s + 0.42 * r}, {0.68 * r, s + 0.71 * r}, {0.55 * r, s + 0.8 * r}};
  PlainMesh mesh;
  add_turned(mesh, body, Vec3::Zero(), Vec3::UnitZ(), 48);
  parts.push_back(finish(mesh, ModelFrame::shaft, ModelMaterial::brushed_steel, 0.4, grain_round_z));
  PlainMesh fingers;
  for (std::size_t k = 1; k < g.shaft.pieces.size(); ++k) {
    const RoundedPiece& piece = g.shaft.pieces[k];
    const Vec3 from = piece.corners[0], to = piece.corners[1], along = (to - from).normalized();
    std::vector<Vec3> path{from - 0.1 * mm * static_cast<double>(k) * along};
    std::vector<double> scale{0.9};
    const auto add = [&](const Vec3& at, double share) {
      path.push_back(at);
      scale.push_back(share);
    };
    add(from + 3.5 * mm * along, 0.98);
    add(from + 3.8 * mm * along, 1);
    for (const double angle : {0.0, 0.3, 0.6, 0.85, 1.1, 1.3})
      add(to + piece.radius * std::sin(angle) * along, std::cos(angle));
    add_rod(fingers, path, scale, rounded_rectangle(0.98 * piece.radius, 0.93 * piece.radius, 0.68 * piece.radius, 6),
            Vec3::UnitX());
  }
  parts.push_back(finish(fingers, ModelFrame::shaft, ModelMaterial::polished_steel, usual_crease, grain_along_z));
  return parts;
}

}  // namespace calot::detail
