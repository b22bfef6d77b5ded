#include "calot/view/surface_stream.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace calot::detail {

void SurfaceStream::set_skin(const TissueSkin& skin) {
  const std::size_t n = skin.vertices.size();
  group_.resize(n);
  first_of_.clear();
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::uint32_t i) { return std::tuple(skin.vertices[i].vertex, skin.vertices[i].cut, i); };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  for (std::size_t k = 0; k < n; ++k) {
    const SkinVertex& v = skin.vertices[order[k]];
    const bool fresh =
        k == 0 || skin.vertices[order[k - 1]].vertex != v.vertex || skin.vertices[order[k - 1]].cut != v.cut;
    if (fresh) first_of_.push_back(order[k]);
    group_[order[k]] = static_cast<std::uint32_t>(first_of_.size() - 1);
  }
  triangles_.clear();
  for (const Triangle& t : skin.triangles) triangles_.push_back({group_[t[0]], group_[t[1]], group_[t[2]]});
}

std::array<std::int16_t, 4> packed_normal(const Eigen::Vector3f& normal) {
  std::array<std::int16_t, 4> out{};
  for (int k = 0; k < 3; ++k)
    out[static_cast<std::size_t>(k)] =
        static_cast<std::int16_t>(std::lrint(std::clamp(normal[k], -1.0F, 1.0F) * 32767.0F));
  return out;
}

namespace {

std::array<std::uint8_t, 4> packed(const SkinCondition& condition) {
  using Four = Eigen::Array4f;
  const Four c(condition.coagulated, condition.charred, condition.blanched, condition.bruised);
  if ((c == 0).all()) return {};  // most tissue
  const Eigen::Array4i bytes = (c.max(0.0F).min(1.0F) * 255.0F + 0.5F).cast<int>();
  return {static_cast<std::uint8_t>(bytes[0]), static_cast<std::uint8_t>(bytes[1]), static_cast<std::uint8_t>(bytes[2]),
          static_cast<std::uint8_t>(bytes[3])};
}

}  // namespace

void SurfaceStream::pack(std::span<const Vec3f> positions, std::span<const SkinCondition> conditions,
                         StreamVertex* out) {
  place_.resize(first_of_.size());
  sum_.assign(first_of_.size(), Eigen::Vector4f::Zero());
  for (std::size_t g = 0; g < place_.size(); ++g) {
    const Vec3f& p = positions[first_of_[g]];
    place_[g] = Eigen::Vector4f(p.x(), p.y(), p.z(), 0);
  }
  for (const auto& [a, b, c] : triangles_) {
    const Eigen::Vector4f normal = (place_[b] - place_[a]).cross3(place_[c] - place_[a]);
    sum_[a] += normal;
    sum_[b] += normal;
    sum_[c] += normal;
  }
  for (std::size_t i = 0; i < group_.size(); ++i) {
    const Eigen::Vector4f& sum = sum_[group_[i]];
    const float length = std::sqrt(std::max(sum.squaredNorm(), 1e-30F));
    const Eigen::Array4i n = (sum.array() * (32767.0F / length)).cast<int>();
    out[i].position = {positions[i].x(), positions[i].y(), positions[i].z()};
    out[i].normal = {static_cast<std::int16_t>(n[0]), static_cast<std::int16_t>(n[1]), static_cast<std::int16_t>(n[2]),
                     0};
    out[i].condition = packed(conditions[i]);
  }
}

}  // namespace calot::detail
