#include "calot/view/models/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace calot::detail {
namespace {

constexpr double mm = model_mm;
constexpr double pin_radius = 0.55 * mm;

/// Across a cheek of the clevis at +x: what is left of a turned body of this radius beyond the plane x = inner, and a
/// plate of that thickness and half width.
struct Cheek {
  double inner = 0, radius = 0, half_width = 0, plate = 0;

  [[nodiscard]] Ring at(double z) const {
    const double turned = std::sqrt(std::max(0.0, radius * radius - inner * inner));
    const double width = std::max(turned, half_width);
    Ring ring{{inner, -width, z}};
    constexpr int steps = 24;
    for (int k = 0; k <= steps; ++k) {
      const double y = width * std::sin(std::numbers::pi * (static_cast<double>(k) / steps - 0.5));
      const double body = std::sqrt(std::max(0.0, radius * radius - y * y));
      const double bevel = std::max(0.0, 0.12 * mm - (half_width - std::abs(y)));
      const double flat = std::abs(y) <= half_width ? inner + plate - 0.8 * bevel : 0.0;
      ring.emplace_back(std::max({body, flat, inner + 0.02 * mm}), y, z);
    }
    ring.emplace_back(inner, width, z);
    return ring;
  }
};

PlainMesh cheek(const Tube& tube, double inner, double outer) {
  constexpr double eye = 1.2 * mm;
  const double r = tube.radius, s = tube.shoulder, plate = outer - inner;
  std::vector<Ring> rings;
  // Cones inside the tube's round end, then the plate alone.
  for (const auto& [radius, along] : {std::pair(0.95, -0.25), std::pair(0.95, 0.08), std::pair(0.94, 0.1),
                                      std::pair(0.85, 0.5), std::pair(0.83, 0.53)})
    rings.push_back(Cheek{inner, radius * r, eye, plate}.at(s + along * r));
  for (const auto& [from, to, low, high] : {std::array{0.83, 0.66, 0.53, 0.73}, std::array{0.64, 0.38, 0.745, 0.92}})
    for (const double share : {0.25, 0.5, 0.75, 1.0})
      rings.push_back(
          Cheek{inner, (from + share * (to - from)) * r, eye, plate}.at(s + (low + share * (high - low)) * r));
  for (const double angle : {-0.2, 0.1, 0.4, 0.65, 0.9, 1.1, 1.25})
    rings.push_back(Cheek{inner, 0, eye * std::cos(angle), plate}.at(eye * std::sin(angle) - 0.1 * mm));
  PlainMesh mesh;
  add_loft(mesh, rings);
  return mesh;
}

}  // namespace

Vec3 grain_round_z(const Vec3& point) {
  return {-point.y(), point.x(), 0};
}
Vec3 grain_along_z(const Vec3& /*point*/) {
  return Vec3::UnitZ();
}

PlainMesh mirrored_in_y(PlainMesh mesh) {
  for (Vec3& p : mesh.positions) p.y() = -p.y();
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

PlainMesh half_turned(PlainMesh mesh) {
  for (Vec3& p : mesh.positions) p = Vec3(-p.x(), -p.y(), p.z());
  return mesh;
}

void append(PlainMesh& mesh, const PlainMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.openness.insert(mesh.openness.end(), other.openness.begin(), other.openness.end());
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

void set_openness(PlainMesh& mesh, std::size_t first, const std::function<double(const Vec3&)>& openness) {
  for (std::size_t k = first; k < mesh.positions.size(); ++k)
    mesh.openness[k] = static_cast<float>(openness(mesh.positions[k]));
}

Tube tube_of(const InstrumentGeometry& geometry) {
  const RoundedPiece& piece = geometry.shaft.pieces.front();
  return {piece.corners[0].z(), piece.corners[1].z(), piece.corners[1].z() + piece.radius, piece.radius};
}

ModelPart insulated_tube(const Tube& tube, double end) {
  const double r = tube.radius, bevel = 0.12 * r;
  const std::vector<Turned> profile{{r, tube.start}, {r, end - bevel}, {0.97 * r, end - 0.3 * bevel}, {0.9 * r, end}};
  PlainMesh mesh;
  add_turned(mesh, profile, Vec3::Zero(), Vec3::UnitZ(), 48);
  return finish(mesh, ModelFrame::shaft, ModelMaterial::insulation, usual_crease, grain_along_z);
}

void add_clevis(Parts& parts, const Tube& tube, double start, double inner, double outer) {
  const double r = tube.radius;
  const std::vector<Turned> profile{{0.9 * r, start}, {0.965 * r, start + 0.05 * r}, {0.965 * r, tube.shoulder}};
  PlainMesh body;
  add_turned(body, profile, Vec3::Zero(), Vec3::UnitZ(), 48);
  set_openness(body, 0, [&](const Vec3& p) { return p.head<2>().norm() < 0.5 * r ? 0.3 : 1.0; });
  parts.push_back(finish(body, ModelFrame::shaft, ModelMaterial::brushed_steel, usual_crease, grain_round_z));
  PlainMesh cheeks = cheek(tube, inner, outer);
  append(cheeks, half_turned(cheeks));
  // Between them, the rod that moves the jaws.
  const double rod = 0.85 * inner;
  const std::vector<Turned> rod_profile{
      {rod, tube.shoulder - 0.5 * mm}, {rod, tube.end - 0.35 * mm}, {0.6 * rod, tube.end - 0.1 * mm}};
  const std::size_t first = cheeks.positions.size();
  add_turned(cheeks, rod_profile, Vec3::Zero(), Vec3::UnitZ(), 24);
  set_openness(cheeks, first, [](const Vec3&) { return 0.4; });
  parts.push_back(finish(cheeks, ModelFrame::shaft, ModelMaterial::brushed_steel, usual_crease, grain_along_z));
  const std::vector<Turned> pin{
      {0, -outer - 0.16 * mm},         {0.6 * pin_radius, -outer - 0.13 * mm}, {pin_radius, -outer - 0.02 * mm},
      {pin_radius, outer + 0.02 * mm}, {0.6 * pin_radius, outer + 0.13 * mm},  {0, outer + 0.16 * mm}};
  PlainMesh mesh;
  add_turned(mesh, pin, Vec3::Zero(), Vec3::UnitX(), 20);
  parts.push_back(finish(mesh, ModelFrame::shaft, ModelMaterial::polished_steel, usual_crease,
                         [](const Vec3& p) { return Vec3(0, -p.z(), p.y()); }));
}

void add_eye(PlainMesh& mesh, double radius, double low, double high) {
  const double bevel = 0.08 * mm;
  const std::vector<Turned> profile{
      {radius - bevel, low}, {radius, low + bevel}, {radius, high - bevel}, {radius - bevel, high}};
  add_turned(mesh, profile, Vec3::Zero(), Vec3::UnitX(), 28);
}

Outline jaw_section(double half_width, double depth, double face, double tooth) {
  Outline outline{{face, -tooth}, {0, -tooth}, {-face, -tooth}};
  constexpr int steps = 10;
  const double shoulder = 0.3 * depth;
  for (int k = 0; k <= steps; ++k) {
    const double angle = std::numbers::pi * (1 + static_cast<double>(k) / steps);
    outline.emplace_back(half_width * std::cos(angle), -shoulder + (depth - shoulder) * std::sin(angle));
  }
  return outline;
}

Ring ring_at(const Outline& section, const Vec3& origin) {
  Ring ring;
  for (const Eigen::Vector2d& p : section) ring.push_back(origin + Vec3(p.x(), p.y(), 0));
  return ring;
}

}  // namespace calot::detail
