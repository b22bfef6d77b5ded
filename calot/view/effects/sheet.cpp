#include "calot/view/effects/sheet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace calot::detail {
namespace {

constexpr float smallest_area = 1e-11F;  // twice a triangle's; below it has no direction [m²]

bool is_index(const Triangle& t, std::size_t count) {
  return t[0] < count && t[1] < count && t[2] < count;
}

/// Twice the area times the normal.
Vec3f area_vector(const std::array<Vec3f, 3>& c) {
  return (c[1] - c[0]).cross(c[2] - c[0]);
}

}  // namespace

void Sheet::take_skin(const TissueSkin& skin, const std::vector<Vec3f>& positions) {
  rest_.clear();
  key_.clear();
  raw_.clear();
  artery_.clear();
  triangles_.clear();
  const bool whole = positions.size() >= skin.vertices.size();
  for (const SkinVertex& vertex : skin.vertices) {
    rest_.push_back(vertex.rest);
    key_.push_back(vertex.vertex);
    raw_.push_back(vertex.cut && vertex.look != TissueLook::duct && vertex.look != TissueLook::artery);
  }
  for (const SkinVertex& vertex : skin.vertices) artery_.push_back(vertex.look == TissueLook::artery);
  for (const Triangle& t : skin.triangles) triangles_.push_back(whole && is_index(t, rest_.size()) ? t : Triangle{});
  now_ = whole ? positions : rest_;
  index();
}

void Sheet::take_still(std::span<const Surface> surfaces) {
  for (const Surface& surface : surfaces) {
    const auto first = static_cast<std::uint32_t>(rest_.size());
    for (const Vec3& p : surface.positions) rest_.push_back(p.cast<float>());
    for (const Triangle& t : surface.triangles)
      triangles_.push_back(is_index(t, surface.positions.size()) ? Triangle{first + t[0], first + t[1], first + t[2]}
                                                                 : Triangle{});
  }
  for (std::size_t v = 0; v < rest_.size(); ++v) key_.push_back(static_cast<std::uint32_t>(v));
  raw_.assign(rest_.size(), 0);
  artery_.assign(rest_.size(), 0);
  now_ = rest_;
  index();
}

/// Rows of the triangles at each key. Numbers too high to be of a mesh of this size are not trusted.
void Sheet::index() {
  std::uint32_t most = 0;
  for (const std::uint32_t key : key_) most = std::max(most, key);
  if (most > 64 * key_.size() + 1024)
    for (std::size_t v = 0; v < key_.size(); ++v) key_[v] = static_cast<std::uint32_t>(v);
  if (most > 64 * key_.size() + 1024) most = static_cast<std::uint32_t>(key_.size());
  start_.assign(static_cast<std::size_t>(most) + 2, 0);
  const auto each = [&](const auto& visit) {
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      if (triangles_[t] != Triangle{})
        for (const std::uint32_t v : triangles_[t]) visit(key_[v], t);
  };
  each([&](std::uint32_t key, std::uint32_t) { ++start_[key + 1]; });
  for (std::size_t k = 1; k < start_.size(); ++k) start_[k] += start_[k - 1];
  around_.resize(start_.back());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  each([&](std::uint32_t key, std::uint32_t t) { around_[next[key]++] = t; });
  seen_.assign(triangles_.size(), 0);
  query_ = 0;
  moved_ = stale_ = true;
}

void Sheet::move(const std::vector<Vec3f>& positions) {
  if (positions.size() < rest_.size()) return;
  now_.assign(positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(rest_.size()));
  moved_ = true;
}

bool Sheet::usable(std::uint32_t t) const {
  if (t >= triangles_.size() || triangles_[t] == Triangle{}) return false;
  const float area = area_vector(corners(t)).norm();
  return area > smallest_area && std::isfinite(area);
}

std::array<Vec3f, 3> Sheet::corners(std::uint32_t t) const {
  const Triangle& triangle = triangles_[t];
  return {now_[triangle[0]], now_[triangle[1]], now_[triangle[2]]};
}

Vec3f Sheet::normal(std::uint32_t t) const {
  return area_vector(corners(t)).normalized();
}

Vec3f Sheet::rest_normal(std::uint32_t t) const {
  const Triangle& triangle = triangles_[t];
  const Vec3f area = area_vector({rest_[triangle[0]], rest_[triangle[1]], rest_[triangle[2]]});
  return area.allFinite() ? area.normalized() : Vec3f::Zero();
}

bool Sheet::is_raw(std::uint32_t t) const {
  const Triangle& triangle = triangles_[t];
  return raw_[triangle[0]] != 0 && raw_[triangle[1]] != 0 && raw_[triangle[2]] != 0;
}

bool Sheet::is_artery(std::uint32_t t) const {
  const Triangle& triangle = triangles_[t];
  return artery_[triangle[0]] != 0 && artery_[triangle[1]] != 0 && artery_[triangle[2]] != 0;
}

Vec3f Sheet::at(const std::vector<Vec3f>& places, const Seat& seat) const {
  const Triangle& t = triangles_[seat.triangle];
  return seat.weights[0] * places[t[0]] + seat.weights[1] * places[t[1]] + seat.weights[2] * places[t[2]];
}

Sheet::Beyond Sheet::across(std::uint32_t t, int k) const {
  const Triangle& triangle = triangles_[t];
  const std::uint32_t a = key_[triangle[static_cast<std::size_t>((k + 1) % 3)]];
  const std::uint32_t b = key_[triangle[static_cast<std::size_t>((k + 2) % 3)]];
  for (std::uint32_t i = start_[a]; i < start_[a + 1]; ++i) {
    const Triangle& other = triangles_[around_[i]];
    for (std::size_t e = 0; e < 3; ++e)
      if (key_[other[e]] == b && key_[other[(e + 1) % 3]] == a && around_[i] != t)
        return {around_[i], static_cast<int>((e + 2) % 3)};
  }
  return {};
}

std::uint32_t Sheet::triangle_of(const std::array<std::uint32_t, 3>& vertices) const {
  if (!is_index(vertices, rest_.size())) return no_triangle;
  const std::uint32_t key = key_[vertices[0]];
  Triangle wanted = vertices;
  std::sort(wanted.begin(), wanted.end());
  for (std::uint32_t i = start_[key]; i < start_[key + 1]; ++i) {
    Triangle here = triangles_[around_[i]];
    std::sort(here.begin(), here.end());
    if (here == wanted) return around_[i];
  }
  return no_triangle;
}

Vec3f nearest_on_triangle(const Vec3f& p, const std::array<Vec3f, 3>& c) {
  const Vec3f ab = c[1] - c[0], ac = c[2] - c[0], ap = p - c[0];
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return Vec3f::UnitX();
  const Vec3f bp = p - c[1];
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return Vec3f::UnitY();
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Vec3f cp = p - c[2];
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return Vec3f::UnitZ();
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const float sum = va + vb + vc;
  return Vec3f(va / sum, vb / sum, vc / sum);
}

Walked walk(const Sheet& sheet, const Seat& from, const Vec3f& way) {
  Walked out{from, Vec3f::Zero(), 0, false};
  Vec3f normal = sheet.normal(from.triangle);
  Vec3f d = way - normal * normal.dot(way);
  for (int crossings = 0; crossings < 64; ++crossings) {
    const auto c = sheet.corners(out.seat.triangle);
    const Vec3f area = area_vector(c);
    Vec3f rate;
    float share = 1;
    int through = -1;
    for (int k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>((k + 1) % 3), b = static_cast<std::size_t>((k + 2) % 3);
      rate[k] = area.dot((c[b] - c[a]).cross(d)) / area.squaredNorm();
      if (rate[k] >= 0 || out.seat.weights[k] + rate[k] >= 0) continue;
      const float s = std::max(0.0F, -out.seat.weights[k] / rate[k]);
      if (s >= share && through >= 0) continue;
      share = std::min(share, s);
      through = k;
    }
    out.seat.weights = (out.seat.weights + share * rate).cwiseMax(0);
    if (through >= 0) out.seat.weights[through] = 0;
    out.seat.weights /= out.seat.weights.sum();
    out.direction = d.normalized();
    if (through < 0) return out;
    d *= 1 - share;
    const auto [next, third] = sheet.across(out.seat.triangle, through);
    if (next == no_triangle || !sheet.usable(next)) {
      out.left = d.norm();
      out.blocked = true;
      return out;
    }
    // Onto the neighbour: the part along the edge stays, the part across it goes on inwards.
    const auto a = static_cast<std::size_t>((through + 1) % 3), b = static_cast<std::size_t>((through + 2) % 3);
    const Vec3f edge = (c[b] - c[a]).normalized();
    const float along = d.dot(edge), across = (d - along * edge).norm();
    const float to_b = out.seat.weights[static_cast<int>(b)];
    const auto corners = sheet.corners(next);
    const auto i = static_cast<std::size_t>(third);
    const Vec3f inward = corners[i] - c[a];
    const Vec3f straight = (inward - edge * inward.dot(edge)).normalized();
    d = along * edge + across * straight;
    // The neighbour names the edge from b to a.
    out.seat.triangle = next;
    out.seat.weights[third] = 0;
    out.seat.weights[(third + 1) % 3] = to_b;
    out.seat.weights[(third + 2) % 3] = 1 - to_b;
    out.direction = d.normalized();
  }
  out.left = d.norm();
  return out;
}

}  // namespace calot::detail
