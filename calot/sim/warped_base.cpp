#include <algorithm>

#include "calot/base/parallel.h"
#include "calot/sim/warped_compliance.h"

namespace calot {
namespace {

// Row u lists u and every vertex that shares a tet or a spring with it, ascending.
BlockMatrix pattern_of(const TetMesh& mesh, const VertexTets& around, std::span<const Spring> springs) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> extra;
  for (const Spring& spring : springs)
    if (spring.other.valid()) {
      extra.emplace_back(spring.vertex.value, spring.other.value);
      extra.emplace_back(spring.other.value, spring.vertex.value);
    }
  std::sort(extra.begin(), extra.end());
  BlockMatrix matrix;
  matrix.row_start.assign(mesh.vertex_count() + 1, 0);
  std::vector<std::uint32_t> row;
  auto next = extra.begin();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    row.assign(1, static_cast<std::uint32_t>(v));
    for (std::uint32_t k = around.start[v]; k < around.start[v + 1]; ++k)
      for (const VertexId u : mesh.tet(around.tets[k])) row.push_back(u.value);
    for (; next != extra.end() && next->first == v; ++next) row.push_back(next->second);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    matrix.column.insert(matrix.column.end(), row.begin(), row.end());
    matrix.row_start[v + 1] = static_cast<std::uint32_t>(matrix.column.size());
  }
  matrix.block.assign(matrix.column.size(), Mat3::Zero());
  return matrix;
}

constexpr std::array<std::array<std::uint8_t, 2>, 10> corner_pairs = {
    {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
constexpr std::uint32_t nowhere = ~0u;

// Where the blocks of each tet go that the factor reads: those whose row comes first in its order. Twice the number of
// the block, and one more where the pair's second corner is the row.
std::vector<std::array<std::uint32_t, 10>> places_of(const BlockMatrix& matrix, const std::vector<Tet>& tets,
                                                     std::span<const std::int32_t> order) {
  std::vector<std::array<std::uint32_t, 10>> places(tets.size());
  parallel_blocks(tets.size(), 512, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t t = begin; t < end; ++t)
      for (std::size_t k = 0; k < corner_pairs.size(); ++k) {
        const std::size_t a = tets[t][corner_pairs[k][0]].index(), b = tets[t][corner_pairs[k][1]].index();
        const bool swapped = order[b] < order[a];
        places[t][k] = order[a] < 0 || order[b] < 0
                           ? nowhere
                           : static_cast<std::uint32_t>(
                                 2 * (matrix.find(swapped ? b : a, swapped ? a : b) - matrix.block.data())) +
                                 (swapped ? 1 : 0);
      }
  });
  return places;
}

// Every block of every tet, turned by its rotation: R K_ab Rᵀ is the block of the tet with turned gradients.
template <class Add>
void each_block(const BaseRequest& request, const Add& add) {
  const Model& model = request.model;
  const TetMesh& mesh = model.mesh();
  const double stiffness = model.dynamics().stiffness_factor();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    TetShape shape =
        tet_shape(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3]));
    const Mat3 r = request.rotations[t].toRotationMatrix();
    for (Vec3& g : shape.gradient) g = r * g;
    shape.volume *= stiffness;
    const Lame lame = model.lame_of(TetId(t));
    for (std::size_t k = 0; k < corner_pairs.size(); ++k)
      add(t, k, [&](int row, int column) { return stiffness_block(shape, lame, row, column); });
  }
}

void add_masses(BlockMatrix& matrix, const Model& model) {
  const std::vector<double> masses = model.vertex_masses();
  for (std::size_t v = 0; v < masses.size(); ++v)
    matrix.find(v, v)->diagonal().array() += model.dynamics().mass_factor() * masses[v];
}

// Both triangles, for the analysis, which gives no room to blocks that are zero.
void add_tets(BlockMatrix& matrix, const BaseRequest& request) {
  const TetMesh& mesh = request.model.mesh();
  each_block(request, [&](std::size_t t, std::size_t k, const auto& block) {
    const auto [a, b] = corner_pairs[k];
    const Mat3 value = block(a, b);
    const std::size_t u = mesh.tets[t][a].index(), v = mesh.tets[t][b].index();
    *matrix.find(u, v) += value;
    if (u != v) *matrix.find(v, u) += value.transpose();
  });
}

// The blocks that the factor reads, where the pattern knows their places.
void add_tets(BlockMatrix& matrix, const BaseRequest& request, const BasePattern& pattern) {
  each_block(request, [&](std::size_t t, std::size_t k, const auto& block) {
    const std::uint32_t place = pattern.places[t][k];
    if (place == nowhere) return;
    const auto [a, b] = corner_pairs[k];
    matrix.block[place / 2] += place % 2 ? block(b, a) : block(a, b);
  });
}

void add_springs(BlockMatrix& matrix, const BaseRequest& request) {
  for (const Spring& spring : request.springs) {
    const Mat3 block = (1 + spring.damping / request.model.dynamics().time_step) * spring.stiffness;
    const std::size_t a = spring.vertex.index();
    *matrix.find(a, a) += block;
    if (!spring.other.valid()) continue;
    const std::size_t b = spring.other.index();
    *matrix.find(b, b) += block;
    *matrix.find(a, b) -= block;
    *matrix.find(b, a) -= block;
  }
}

}  // namespace

namespace {

std::vector<std::int32_t> rows_of_slots(const FactorPattern& pattern, std::span<const std::uint8_t> active) {
  std::vector<std::int32_t> rows(active.size(), -1);
  std::uint32_t number = 0;
  for (std::size_t v = 0; v < active.size(); ++v)
    if (active[v]) rows[v] = static_cast<std::int32_t>(3 * pattern.position[number++]);
  return rows;
}

BlockMatrix zero_like(const BlockMatrix& structure) {
  return {structure.row_start, structure.column, std::vector<Mat3>(structure.column.size(), Mat3::Zero())};
}

}  // namespace

std::unique_ptr<WarpedBase> make_base(const BaseRequest& request) {
  const Model& model = request.model;
  std::vector<std::uint8_t> active(model.fixed().size());
  std::transform(model.fixed().begin(), model.fixed().end(), active.begin(), [](std::uint8_t f) { return f == 0; });
  auto base = std::make_unique<WarpedBase>();
  BlockMatrix matrix;
  std::shared_ptr<const BasePattern> shared = request.pattern;
  if (!shared) {
    matrix = pattern_of(model.mesh(), vertex_tets(model.mesh()), request.springs);
    add_tets(matrix, request);
    add_masses(matrix, model);
    add_springs(matrix, request);
    const auto fresh = std::make_shared<BasePattern>();
    fresh->factor = std::make_shared<const FactorPattern>(analyse(matrix, active));
    fresh->structure = {matrix.row_start, matrix.column, {}};
    shared = fresh;
  } else {
    matrix = zero_like(shared->structure);
    if (shared->tets != model.mesh().tets) {  // the first that shares the pattern, or tets went
      const auto fresh = std::make_shared<BasePattern>(*shared);
      fresh->tets = model.mesh().tets;
      fresh->places = places_of(matrix, fresh->tets, rows_of_slots(*shared->factor, active));
      shared = fresh;
    }
    add_tets(matrix, request, *shared);
    add_masses(matrix, model);
    add_springs(matrix, request);
  }
  base->shared = shared;
  base->pattern = shared->factor;
  base->factor = SparseFactor(base->pattern, matrix, active);
  base->single = FloatFactor(base->factor);
  base->compact = CompactFactor(base->factor);
  base->row_of_slot = rows_of_slots(*base->pattern, active);
  std::vector<std::uint32_t> likely;
  for (const VertexId v : request.likely)
    if (base->row_of_slot[v.index()] >= 0) likely.push_back(static_cast<std::uint32_t>(base->row_of_slot[v.index()]));
  base->ready.add(base->factor, likely);
  return base;
}

}  // namespace calot
