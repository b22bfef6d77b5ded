#include "calot/sim/tear.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/base/wide.h"
#include "calot/sim/tear_faces.h"

namespace calot {
namespace {

constexpr std::uint8_t stuck_after = 6;  // tries
constexpr double least_strain_share =
    0.1;  // tissue that bears less than this of its limit is never torn by a neighbour

}  // namespace

Tearing::Tearing(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
                 const TearOptions& options)
    : options_(options) {
  if (options.steps_to_tear < 1 || options.steps_to_tear > 200 || !(options.weak_share >= 0 && options.weak_share <= 1))
    throw InputError("tearing", "an option is out of range", "give 1 ... 200 steps and a share in 0 ... 1");
  for (const auto& [region, tissue] : properties) {
    if (!(tissue.ultimate_stretch > 1) || !std::isfinite(tissue.ultimate_stretch))
      throw InputError("tearing", "the ultimate stretch of region " + std::to_string(region) + " is not above 1",
                       "give one above 1");
    kinds_.push_back({region, tissue.ultimate_stretch, tissue.ultimate_stretch * tissue.ultimate_stretch});
  }
  const std::size_t m = mesh.tet_count();
  kind_.resize(m);
  for (std::size_t t = 0; t < m; ++t) {
    const auto kind =
        std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& k) { return k.region == mesh.regions[t]; });
    if (kind == kinds_.end())
      throw InputError("tearing", "region " + std::to_string(mesh.regions[t]) + " has no properties",
                       "give every region of the mesh its tissue");
    kind_[t] = static_cast<std::uint8_t>(kind - kinds_.begin());
  }
  over_.assign(m, 0);
  tries_.assign(m, 0);
  squared_.assign(m, 1);
  build(mesh);
}

void Tearing::build(const TetMesh& mesh) {
  const std::size_t m = mesh.tet_count();
  blocks_.resize((m + lanes - 1) / lanes);
  for (std::size_t i = 0; i < blocks_.size() * lanes; ++i) {
    const Tet& tet = mesh.tets[std::min(i, m - 1)];
    Block& block = blocks_[i / lanes];
    for (std::size_t c = 0; c < 4; ++c) block.vertex[c][i % lanes] = tet[c].value;
    const Vec3& origin = mesh.position(tet[0]);
    Eigen::Matrix3d rest;
    for (int c = 0; c < 3; ++c) rest.col(c) = mesh.position(tet[static_cast<std::size_t>(c) + 1]) - origin;
    const Eigen::Matrix3d inverse = rest.inverse();
    for (int k = 0; k < 9; ++k) block.inverse[static_cast<std::size_t>(k)][i % lanes] = inverse(k / 3, k % 3);
  }
}

/// Largest eigenvalue of C = FᵀF and det F, eight tets at a time. With q = tr C / 3, p² = ‖C − q I‖²/6 and
/// r = det(C − q I)/(2 p³), the eigenvalue is q + p x, x the largest root of x³ − 3x = 2r, in 1 … 2. For ε = x − 1 it
/// reads ε³ + 3ε² = 2(1 + r), which Newton's method solves from √(2(1 + r)/3) at any r, without trigonometry.
/// Where the two largest eigenvalues meet, rounding leaves an error of 1e-8. Source of the reduction: [Smith1961].
CALOT_WIDE void Tearing::measure(const Block& block, const double* x, Lane& squared_stretch, Lane& determinant) {
  std::array<Lane, 9> edge;  // row-major, columns are the edges from corner 0
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t l = 0; l < lanes; ++l)
      for (std::size_t axis = 0; axis < 3; ++axis)
        edge[3 * axis + c][l] = x[3 * block.vertex[c + 1][l] + axis] - x[3 * block.vertex[0][l] + axis];
  std::array<Lane, 9> f;
  const auto& inv = block.inverse;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t l = 0; l < lanes; ++l)
        f[3 * i + j][l] =
            edge[3 * i][l] * inv[j][l] + edge[3 * i + 1][l] * inv[3 + j][l] + edge[3 * i + 2][l] * inv[6 + j][l];
  for (std::size_t l = 0; l < lanes; ++l) {
    const double f0 = f[0][l], f1 = f[1][l], f2 = f[2][l], f3 = f[3][l], f4 = f[4][l], f5 = f[5][l], f6 = f[6][l],
                 f7 = f[7][l], f8 = f[8][l];
    determinant[l] = f0 * (f4 * f8 - f5 * f7) - f1 * (f3 * f8 - f5 * f6) + f2 * (f3 * f7 - f4 * f6);
    double a = f0 * f0 + f3 * f3 + f6 * f6, b = f1 * f1 + f4 * f4 + f7 * f7, c = f2 * f2 + f5 * f5 + f8 * f8;
    const double d = f0 * f1 + f3 * f4 + f6 * f7, e = f0 * f2 + f3 * f5 + f6 * f8, g = f1 * f2 + f4 * f5 + f7 * f8;
    const double q = (a + b + c) / 3;
    a -= q;
    b -= q;
    c -= q;
    const double p = std::sqrt((a * a + b * b + c * c + 2 * (d * d + e * e + g * g)) / 6);
    const double det = a * (b * c - g * g) - d * (d * c - g * e) + e * (d * g - b * e);
    const double r = det / (2 * p * p * p + 1e-300);
    const double w = 2 + std::abs(r + 1) - std::abs(r - 1);  // 2 (1 + r), r kept in −1 … 1 without a branch
    double root = std::sqrt(w / 3);
    root -= (root * root * (root + 3) - w) / (3 * root * (root + 2) + 1e-300);
    root -= (root * root * (root + 3) - w) / (3 * root * (root + 2) + 1e-300);
    root -= (root * root * (root + 3) - w) / (3 * root * (root + 2) + 1e-300);
    root -= (root * root * (root + 3) - w) / (3 * root * (root + 2) + 1e-300);
    squared_stretch[l] = q + p * (1 + root);
  }
}

double Tearing::stretch(TetId tet) const {
  return std::sqrt(squared_[tet.index()]);
}

double Tearing::utilisation(std::size_t t) const {
  return (std::sqrt(squared_[t]) - 1) / (kinds_[kind_[t]].limit - 1);
}

/// Largest stretch by region, and which tets are beyond their limit.
void Tearing::survey(const TetMesh& mesh) {
  report_.by_region.clear();
  for (const Kind& kind : kinds_) report_.by_region.push_back({kind.region, 0, 0, TetId::none()});
  over_now_.clear();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    RegionStretch& region = report_.by_region[kind_[t]];
    if (squared_[t] > region.largest) {
      region.largest = squared_[t];
      region.tet = TetId(t);
    }
    if (!(squared_[t] > kinds_[kind_[t]].squared)) {  // not a number: reported as inverted
      over_[t] = tries_[t] = 0;
      continue;
    }
    over_[t] = static_cast<std::uint8_t>(std::min(over_[t] + 1, 200));
    if (over_[t] >= options_.steps_to_tear) over_now_.emplace_back(t);
  }
  report_.largest = 0;
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    RegionStretch& region = report_.by_region[k];
    region.largest = region.tet.valid() ? std::sqrt(region.largest) : 1;
    region.utilisation = (region.largest - 1) / (kinds_[k].limit - 1);
    report_.largest = std::max(report_.largest, region.tet.valid() ? region.largest : 0);
  }
}

/// The direction of largest stretch, in the rest shape.
Vec3 Tearing::direction(std::size_t t, std::span<const Vec3> positions) const {
  const Block& block = blocks_[t / lanes];
  const std::size_t l = t % lanes;
  Eigen::Matrix3d now, inverse;
  for (int k = 0; k < 9; ++k) inverse(k / 3, k % 3) = block.inverse[static_cast<std::size_t>(k)][l];
  for (int c = 0; c < 3; ++c)
    now.col(c) = positions[block.vertex[static_cast<std::size_t>(c) + 1][l]] - positions[block.vertex[0][l]];
  const Eigen::Matrix3d f = now * inverse;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(f.transpose() * f);
  return eigen.eigenvectors().col(2);
}

/// Adds the faces that part the tets around one face of `tet` into those on either side of the plane through that
/// face's middle across `along`. Faces in tissue far from its own limit hold.
void Tearing::crack(const TetMesh& mesh, const VertexTets& around, TetId tet, const Vec3& along) {
  double best = -1;
  std::array<VertexId, 3> start{};
  for (std::size_t f = 0; f < 4; ++f) {
    if (!detail::across(mesh, around, tet, f).valid()) continue;
    const auto face = detail::face_of(mesh.tet(tet), f);
    const Vec3 &a = mesh.position(face[0]), &b = mesh.position(face[1]), &c = mesh.position(face[2]);
    const double alignment = std::abs((b - a).cross(c - a).normalized().dot(along));
    if (alignment <= best) continue;
    best = alignment;
    start = face;
  }
  if (best < 0) return;  // a tet on its own
  const auto height = [&](const Vec3& x) { return x.dot(along); };
  const double plane =
      (height(mesh.position(start[0])) + height(mesh.position(start[1])) + height(mesh.position(start[2]))) / 3;
  const auto above = [&](TetId t) {
    double sum = 0;
    for (const VertexId v : mesh.tet(t)) sum += height(mesh.position(v));
    return sum / 4 >= plane;
  };
  const double needed = std::max(least_strain_share, options_.weak_share / (1 << tries_[tet.index()]));
  std::vector<TetId> near;
  for (const VertexId v : start)
    near.insert(near.end(), around.tets.begin() + around.start[v.index()],
                around.tets.begin() + around.start[v.index() + 1]);
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  for (const TetId t : near) {
    if (!above(t)) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      const auto face = detail::face_of(mesh.tet(t), f);
      const bool touches = std::any_of(face.begin(), face.end(),
                                       [&](VertexId v) { return v == start[0] || v == start[1] || v == start[2]; });
      if (!touches) continue;
      const TetId other = detail::across(mesh, around, t, f);
      if (!other.valid() || above(other)) continue;
      if (std::max(utilisation(t.index()), utilisation(other.index())) >= needed) report_.faces.push_back(face);
    }
  }
}

/// The worst tets crack first; those that touch one that cracks wait until they have felt it.
void Tearing::give_way(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> positions) {
  std::sort(over_now_.begin(), over_now_.end(), [&](TetId a, TetId b) {
    const double ua = utilisation(a.index()), ub = utilisation(b.index());
    return ua != ub ? ua > ub : a < b;
  });
  for (const TetId tet : over_now_) {
    if (tries_[tet.index()] >= stuck_after) report_.stuck.push_back(tet);
    if (report_.torn.size() >= options_.max_tears) continue;
    const bool waits = std::any_of(report_.torn.begin(), report_.torn.end(), [&](TetId torn) {
      return std::any_of(mesh.tet(tet).begin(), mesh.tet(tet).end(),
                         [&](VertexId v) { return detail::has(mesh.tet(torn), v); });
    });
    if (waits) continue;
    crack(mesh, around, tet, direction(tet.index(), positions));
    report_.torn.push_back(tet);
    over_[tet.index()] = 0;
    tries_[tet.index()] = static_cast<std::uint8_t>(std::min<int>(tries_[tet.index()] + 1, stuck_after));
  }
  std::sort(report_.stuck.begin(), report_.stuck.end());
  for (auto& face : report_.faces) std::sort(face.begin(), face.end());
  std::sort(report_.faces.begin(), report_.faces.end());
  report_.faces.erase(std::unique(report_.faces.begin(), report_.faces.end()), report_.faces.end());
}

const TearStep& Tearing::step(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> positions) {
  report_.inverted.clear();
  report_.torn.clear();
  report_.stuck.clear();
  report_.faces.clear();
  const std::size_t m = mesh.tet_count();
  Lane squared, determinant;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    measure(blocks_[b], positions[0].data(), squared, determinant);
    const std::size_t first = b * lanes, count = std::min(lanes, m - first);
    for (std::size_t l = 0; l < count; ++l) {
      squared_[first + l] = squared[l];
      if (!(determinant[l] > 0)) report_.inverted.emplace_back(first + l);
    }
  }
  survey(mesh);
  if (!over_now_.empty()) give_way(mesh, around, positions);
  return report_;
}

void Tearing::follow(const Remap& remap, const TetMesh& mesh) {
  const auto carry = [&](auto& field, bool to_pieces, auto fresh) {
    std::remove_reference_t<decltype(field)> after(remap.tet_to_old.size(), fresh);
    for (std::size_t t = 0; t < after.size(); ++t)
      if (remap.tet_to_old[t].valid()) after[t] = field[remap.tet_to_old[t].index()];
    if (to_pieces)
      for (std::size_t k = 0; k < remap.added_tets.size(); ++k)
        after[remap.added_tets[k].index()] = field[remap.added_parents[k].index()];
    field = std::move(after);
  };
  carry(kind_, true, std::uint8_t{0});
  carry(squared_, true, 1.0);
  carry(tries_, true, std::uint8_t{0});
  carry(over_, false, std::uint8_t{0});  // a piece has to be beyond the limit anew
  build(mesh);
}

void Tearing::append_state(std::string& bytes) const {
  detail::append_bytes(bytes, over_);
  detail::append_bytes(bytes, tries_);
  detail::append_bytes(bytes, squared_);
}

}  // namespace calot
