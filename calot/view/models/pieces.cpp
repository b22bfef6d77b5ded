#include "calot/view/models/pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calot::detail {
namespace {

constexpr double mm = model_mm;
constexpr double pin_radius = 0.55 * mm;

/// A cheek of the clevis at +x: flat inside at x = inner, arched outside.
Ring cheek_ring(double z, double inner, double half_width, double thickness) {
  Ring ring;
  constexpr int steps = 10;
  for (int k = 0; k <= steps; ++k) {
    const double s = -1 + 2.0 * k / steps;
    const double arch = k == 0 || k == steps ? 0.0 : std::sqrt(1 - s * s);
    ring.emplace_back(inner + thickness * std::min(1.0, 0.25 + 0.75 * arch), half_width * s, z);
    if (k == 0) ring.back().x() = inner + 0.05 * thickness;
    if (k == steps) ring.back().x() = inner + 0.05 * thickness;
  }
  ring.emplace_back(inner, half_width * 0.94, z);
  ring.emplace_back(inner, -half_width * 0.94, z);
  return ring;
}

/// Radius of the tube's rounded end at z.
double dome_radius(const Tube& tube, double z) {
  const double up = std::max(0.0, z - tube.shoulder);
  return std::sqrt(std::max(0.0, tube.radius * tube.radius - up * up));
}

PlainMesh cheek(const Tube& tube, double inner, double outer) {
  const double eye = 1.2 * mm, plate = outer - inner;
  std::vector<Ring> rings;
  rings.push_back(cheek_ring(tube.shoulder - 0.6 * mm, inner, 0.9 * tube.radius, 0.9 * tube.radius - inner));
  constexpr int steps = 9;
  for (int k = 0; k <= steps; ++k) {
    const double z = tube.shoulder + 0.2 * mm + k * (tube.end - 0.4 * mm - tube.shoulder) / steps;
    const double r = std::max(0.97 * dome_radius(tube, z), outer);
    const double width = std::sqrt(r * r - inner * inner);
    rings.push_back(cheek_ring(z, inner, std::max(width, eye), r - inner));
  }
  for (const double angle : {-0.3, 0.0, 0.3, 0.6, 0.9, 1.15})
    rings.push_back(cheek_ring(eye * std::sin(angle) - 0.1 * mm, inner, eye * std::cos(angle), plate));
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
  const std::vector<Turned> profile{{0.9 * r, start},
                                    {0.95 * r, start + 0.05 * r},
                                    {0.95 * r, tube.shoulder - 0.4 * mm},
                                    {0.9 * r, tube.shoulder - 0.2 * mm},
                                    {0.9 * r, tube.shoulder}};
  PlainMesh body;
  add_turned(body, profile, Vec3::Zero(), Vec3::UnitZ(), 48);
  set_openness(body, 0, [&](const Vec3& p) { return p.head<2>().norm() < 0.5 * r ? 0.3 : 1.0; });
  parts.push_back(finish(body, ModelFrame::shaft, ModelMaterial::brushed_steel, usual_crease, grain_round_z));
  PlainMesh cheeks = cheek(tube, inner, outer);
  append(cheeks, half_turned(cheeks));
  parts.push_back(finish(cheeks, ModelFrame::shaft, ModelMaterial::brushed_steel, usual_crease, grain_along_z));
  const std::vector<Turned> pin{{0.8 * pin_radius, -outer - 0.1 * mm},
                                {pin_radius, -outer - 0.04 * mm},
                                {pin_radius, outer + 0.04 * mm},
                                {0.8 * pin_radius, outer + 0.1 * mm}};
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
