#include "calot/sim/corotational.h"

#include <algorithm>
#include <cmath>

#include "calot/base/parallel.h"
#include "calot/base/wide.h"

namespace calot {
namespace {

constexpr std::size_t blocks_at_once = 64;  // of a parallel loop
// Below this a product takes less than a millisecond on one thread, and waking another costs more than it brings, most
// of all where background work has the other core (docs/performance.md).
constexpr std::size_t blocks_for_threads = 8192;

template <class Body>
void on_blocks(std::size_t blocks, std::size_t count, std::size_t at_once, const Body& body) {
  if (blocks < blocks_for_threads) return body(std::size_t{0}, count, std::size_t{0});
  parallel_blocks(count, at_once, body);
}
constexpr int newton_steps = 4;
constexpr double small_enough = 1e-5;  // Newton's next step would be of this size squared [rad]

using Lane = std::array<double, 8>;
#define CALOT_LANES for (std::size_t l = 0; l < 8; ++l)

// F = Σ (x_a − x_0) g_aᵀ of eight tets, row-major; `in` holds three values a vertex.
inline void gradient_of(const std::array<std::array<std::uint32_t, 8>, 4>& vertex, const std::array<Lane, 9>& g,
                        const double* in, std::array<Lane, 9>& f) {
  std::array<Lane, 9> edge;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < 3; ++i)
      CALOT_LANES edge[3 * a + i][l] =
          in[3 * std::size_t{vertex[a + 1][l]} + i] - in[3 * std::size_t{vertex[0][l]} + i];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      CALOT_LANES f[3 * i + j][l] = edge[i][l] * g[j][l] + edge[3 + i][l] * g[3 + j][l] + edge[6 + i][l] * g[6 + j][l];
}

// S = Rᵀ F.
inline void unrotate(const std::array<Lane, 9>& r, const std::array<Lane, 9>& f, std::array<Lane, 9>& s) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      CALOT_LANES s[3 * i + j][l] = r[i][l] * f[j][l] + r[3 + i][l] * f[3 + j][l] + r[6 + i][l] * f[6 + j][l];
}

inline void matrix_of(const std::array<Lane, 4>& q, std::array<Lane, 9>& r) {
  CALOT_LANES {
    const double w = q[0][l], x = q[1][l], y = q[2][l], z = q[3][l];
    r[0][l] = 1 - 2 * (y * y + z * z);
    r[1][l] = 2 * (x * y - w * z);
    r[2][l] = 2 * (x * z + w * y);
    r[3][l] = 2 * (x * y + w * z);
    r[4][l] = 1 - 2 * (x * x + z * z);
    r[5][l] = 2 * (y * z - w * x);
    r[6][l] = 2 * (x * z - w * y);
    r[7][l] = 2 * (y * z + w * x);
    r[8][l] = 1 - 2 * (x * x + y * y);
  }
}

// One step of Newton's method towards the rotation that maximises tr(RᵀF): (tr S · I − sym S) ω = axial(S), R ← R exp
// ω. Where that matrix is not safely positive (a tet about to turn inside out) the step goes along the axial vector
// alone.
// @return the largest |ω|
inline double newton_step(const std::array<Lane, 9>& s, std::array<Lane, 4>& q) {
  Lane size;
  CALOT_LANES {
    const double trace = s[0][l] + s[4][l] + s[8][l];
    const double ax = s[7][l] - s[5][l], ay = s[2][l] - s[6][l], az = s[3][l] - s[1][l];
    const double xx = s[4][l] + s[8][l], yy = s[0][l] + s[8][l], zz = s[0][l] + s[4][l];
    const double xy = -0.5 * (s[1][l] + s[3][l]), xz = -0.5 * (s[2][l] + s[6][l]), yz = -0.5 * (s[5][l] + s[7][l]);
    const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - yy * xz;
    const double det = xx * cxx + xy * cxy + xz * cxz;
    const double scale = std::abs(trace) + 1e-9;
    const bool safe = det > 1e-3 * scale * scale * scale && cxx > 0 && xx > 0;
    const double over = safe ? 1 / det : 0, plain = safe ? 0 : 1 / scale;
    double wx = (cxx * ax + cxy * ay + cxz * az) * over + ax * plain;
    double wy = (cxy * ax + (xx * zz - xz * xz) * ay + (xy * xz - xx * yz) * az) * over + ay * plain;
    double wz = (cxz * ax + (xy * xz - xx * yz) * ay + (xx * yy - xy * xy) * az) * over + az * plain;
    const double length = std::sqrt(wx * wx + wy * wy + wz * wz);
    const double shrink = length > 1 ? 1 / length : 1;
    wx *= 0.5 * shrink;
    wy *= 0.5 * shrink;
    wz *= 0.5 * shrink;
    // q ← q · (1, ω/2), normalised: exp ω to third order, which Newton's next step mends.
    const double w = q[0][l], x = q[1][l], y = q[2][l], z = q[3][l];
    const double nw = w - x * wx - y * wy - z * wz, nx = x + w * wx + y * wz - z * wy;
    const double ny = y + w * wy + z * wx - x * wz, nz = z + w * wz + x * wy - y * wx;
    const double norm = 1 / std::sqrt(nw * nw + nx * nx + ny * ny + nz * nz);
    q[0][l] = nw * norm;
    q[1][l] = nx * norm;
    q[2][l] = ny * norm;
    q[3][l] = nz * norm;
    size[l] = length;
  }
  double largest = 0;
  CALOT_LANES largest = std::max(largest, size[l]);
  return largest;
}

// Volume times stress: λ tr(ε) I + 2μ ε with ε = sym(S) − identity·I.
inline void stress_of(const std::array<Lane, 9>& s, const Lane& lambda, const Lane& two_mu, double identity,
                      std::array<Lane, 6>& p) {
  CALOT_LANES {
    const double xx = s[0][l] - identity, yy = s[4][l] - identity, zz = s[8][l] - identity;
    const double pressure = lambda[l] * (xx + yy + zz);
    p[0][l] = pressure + two_mu[l] * xx;
    p[1][l] = pressure + two_mu[l] * yy;
    p[2][l] = pressure + two_mu[l] * zz;
    p[3][l] = 0.5 * two_mu[l] * (s[1][l] + s[3][l]);
    p[4][l] = 0.5 * two_mu[l] * (s[5][l] + s[7][l]);
    p[5][l] = 0.5 * two_mu[l] * (s[2][l] + s[6][l]);
  }
}

inline void turn(const std::array<Lane, 4>& q, const std::array<Lane, 9>& g, std::array<Lane, 9>& turned) {
  std::array<Lane, 9> r;
  matrix_of(q, r);
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < 3; ++i)
      CALOT_LANES turned[3 * a + i][l] =
          r[3 * i][l] * g[3 * a][l] + r[3 * i + 1][l] * g[3 * a + 1][l] + r[3 * i + 2][l] * g[3 * a + 2][l];
}

constexpr std::size_t symmetric[9] = {0, 3, 5, 3, 1, 4, 5, 4, 2};

}  // namespace

// For an isotropic tissue R P(Rᵀ F) g = P(sym(F Rᵀ)) R g: with the gradients turned, R itself isn't needed.
CALOT_WIDE void Corotational::block_forces(const Block& block, const BlockRotation& rotation, const double* in,
                                           double identity, double* out) {
  std::array<Lane, 9> s;
  std::array<Lane, 6> p;
  gradient_of(block.vertex, rotation.gradient, in, s);
  stress_of(s, block.lambda, block.two_mu, identity, p);
  std::array<Lane, 12> corner;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t a = 0; a < 3; ++a)
      CALOT_LANES corner[3 * (a + 1) + i][l] = p[symmetric[3 * i]][l] * rotation.gradient[3 * a][l] +
                                               p[symmetric[3 * i + 1]][l] * rotation.gradient[3 * a + 1][l] +
                                               p[symmetric[3 * i + 2]][l] * rotation.gradient[3 * a + 2][l];
    CALOT_LANES corner[i][l] = -(corner[3 + i][l] + corner[6 + i][l] + corner[9 + i][l]);
  }
  CALOT_LANES for (std::size_t k = 0; k < 12; ++k) out[12 * l + k] = corner[k][l];
}

CALOT_WIDE double Corotational::rotate_block(const Block& block, BlockRotation& rotation, const double* positions) {
  std::array<Lane, 9> f, r, s;
  gradient_of(block.vertex, block.gradient, positions, f);
  matrix_of(rotation.quaternion, r);
  double missing = 0;
  for (int step = 0; step < newton_steps; ++step) {
    unrotate(r, f, s);
    missing = newton_step(s, rotation.quaternion);
    matrix_of(rotation.quaternion, r);
    if (missing < small_enough) break;  // of this block alone: the same on any number of threads
  }
  turn(rotation.quaternion, block.gradient, rotation.gradient);
  return missing;
}

void Corotational::turn_gradient(const Block& block, BlockRotation& rotation) {
  turn(rotation.quaternion, block.gradient, rotation.gradient);
}

double Corotational::block_energy(const Block& block, const BlockRotation& rotation, const double* positions) {
  std::array<Lane, 9> s;
  std::array<Lane, 6> p;
  gradient_of(block.vertex, rotation.gradient, positions, s);
  stress_of(s, block.lambda, block.two_mu, 1, p);
  double sum = 0;
  CALOT_LANES sum +=
      0.5 * (p[0][l] * (s[0][l] - 1) + p[1][l] * (s[4][l] - 1) + p[2][l] * (s[8][l] - 1) +
             p[3][l] * (s[1][l] + s[3][l]) + p[4][l] * (s[5][l] + s[7][l]) + p[5][l] * (s[2][l] + s[6][l]));
  return sum;
}

Corotational::Corotational(const Model& model) {
  rebuild(model);
  rotations_.resize(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    for (auto& lane : rotations_[b].quaternion) lane.fill(0);
    rotations_[b].quaternion[0].fill(1);
    turn_gradient(blocks_[b], rotations_[b]);
  }
}

void Corotational::rebuild(const Model& model) {
  const TetMesh& mesh = model.mesh();
  tet_count_ = mesh.tet_count();
  vertex_count_ = mesh.vertex_count();
  blocks_.resize((tet_count_ + lanes - 1) / lanes);
  parallel_blocks(blocks_.size(), blocks_at_once, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t b = begin; b < end; ++b)
      for (std::size_t l = 0; l < lanes; ++l) {
        Block& block = blocks_[b];
        const std::size_t t = std::min(lanes * b + l, tet_count_ - 1);
        const bool used = lanes * b + l < tet_count_;
        const Tet& tet = mesh.tets[t];
        const TetShape shape =
            tet_shape(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3]));
        const Lame lame = model.lame_of(TetId(t));
        for (std::size_t a = 0; a < 4; ++a) block.vertex[a][l] = tet[a].value;
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t i = 0; i < 3; ++i)
            block.gradient[3 * a + i][l] = shape.gradient[a + 1][static_cast<Eigen::Index>(i)];
        block.lambda[l] = used ? shape.volume * lame.lambda : 0;
        block.two_mu[l] = used ? 2 * shape.volume * lame.mu : 0;
      }
  });
  corner_forces_.resize(12 * lanes * blocks_.size());
  corner_start_.assign(vertex_count_ + 1, 0);
  for (const Tet& tet : mesh.tets)
    for (const VertexId v : tet) ++corner_start_[v.index() + 1];
  for (std::size_t v = 0; v < vertex_count_; ++v) corner_start_[v + 1] += corner_start_[v];
  corner_.resize(4 * tet_count_);
  std::vector<std::uint32_t> next(corner_start_.begin(), corner_start_.end() - 1);
  for (std::size_t t = 0; t < tet_count_; ++t)
    for (std::size_t a = 0; a < 4; ++a)
      corner_[next[mesh.tets[t][a].index()]++] = static_cast<std::uint32_t>(3 * (4 * t + a));
}

void Corotational::restiffen(const Model& model) {
  rebuild(model);  // the shapes stay, so do the turned gradients
}

void Corotational::follow(const Model& model, const Remap& remap) {
  const std::vector<Eigen::Quaterniond> before = rotations();
  rebuild(model);
  std::vector<Eigen::Quaterniond> now(tet_count_);
  for (std::size_t t = 0; t < tet_count_; ++t)
    if (remap.tet_to_old[t].valid()) now[t] = before[remap.tet_to_old[t].index()];
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k)
    now[remap.added_tets[k].index()] = before[remap.added_parents[k].index()];
  set_rotations(now);
}

double Corotational::update_rotations(std::span<const Vec3> positions) {
  const double* in = positions.data()->data();
  std::vector<double> missing((blocks_.size() + blocks_at_once - 1) / blocks_at_once, 0.0);
  parallel_blocks(blocks_.size(), blocks_at_once, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    double largest = 0;
    for (std::size_t b = begin; b < end; ++b) largest = std::max(largest, rotate_block(blocks_[b], rotations_[b], in));
    missing[chunk] = largest;
  });
  return missing.empty() ? 0 : *std::max_element(missing.begin(), missing.end());
}

template <Corotational::Product product>
void Corotational::apply(std::span<const Vec3> in, std::span<Vec3> out) const {
  const double* values = in.data()->data();
  on_blocks(blocks_.size(), blocks_.size(), blocks_at_once, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t b = begin; b < end; ++b)
      block_forces(blocks_[b], rotations_[b], values, product == Product::force ? 1 : 0,
                   corner_forces_.data() + 12 * lanes * b);
  });
  sum_corners(out);
}

void Corotational::sum_corners(std::span<Vec3> out) const {
  on_blocks(blocks_.size(), vertex_count_, 512, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t v = begin; v < end; ++v) {
      double x = 0, y = 0, z = 0;
      for (std::uint32_t k = corner_start_[v]; k < corner_start_[v + 1]; ++k) {
        const double* f = corner_forces_.data() + corner_[k];
        x += f[0];
        y += f[1];
        z += f[2];
      }
      out[v] = Vec3(x, y, z);
    }
  });
}

void Corotational::multiply(std::span<const Vec3> displacements, std::span<Vec3> out) const {
  apply<Product::linear>(displacements, out);
}

void Corotational::force(std::span<const Vec3> positions, std::span<Vec3> out) const {
  apply<Product::force>(positions, out);
  for (Vec3& f : out) f = -f;
}

double Corotational::energy(std::span<const Vec3> positions) const {
  double sum = 0;
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    sum += block_energy(blocks_[b], rotations_[b], positions.data()->data());
  return sum;
}

Eigen::Quaterniond Corotational::rotation(TetId tet) const {
  const BlockRotation& r = rotations_[tet.index() / lanes];
  const std::size_t l = tet.index() % lanes;
  return {r.quaternion[0][l], r.quaternion[1][l], r.quaternion[2][l], r.quaternion[3][l]};
}

std::vector<Eigen::Quaterniond> Corotational::rotations() const {
  std::vector<Eigen::Quaterniond> all(tet_count_);
  for (std::size_t t = 0; t < tet_count_; ++t) all[t] = rotation(TetId(t));
  return all;
}

void Corotational::set_rotations(std::span<const Eigen::Quaterniond> rotations) {
  rotations_.resize(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    for (std::size_t l = 0; l < lanes; ++l) {
      const Eigen::Quaterniond& q = rotations[std::min(lanes * b + l, tet_count_ - 1)];
      rotations_[b].quaternion[0][l] = q.w();
      rotations_[b].quaternion[1][l] = q.x();
      rotations_[b].quaternion[2][l] = q.y();
      rotations_[b].quaternion[3][l] = q.z();
    }
    turn_gradient(blocks_[b], rotations_[b]);
  }
}

}  // namespace calot
