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

// Â with every tet turned by its rotation: R K_ab Rᵀ is the block of the tet with turned gradients.
void add_tets(BlockMatrix& matrix, const BaseRequest& request, const VertexTets& around) {
  const Model& model = request.model;
  const TetMesh& mesh = model.mesh();
  std::vector<TetShape> shapes(mesh.tet_count());
  std::vector<Lame> lames(mesh.tet_count());
  for (std::size_t t = 0; t < shapes.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    shapes[t] = tet_shape(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3]));
    const Mat3 r = request.rotations[t].toRotationMatrix();
    for (Vec3& g : shapes[t].gradient) g = r * g;
    lames[t] = model.lame_of(TetId(t));
  }
  const double stiffness = model.dynamics().stiffness_factor(), inertia = model.dynamics().mass_factor();
  const std::vector<double> masses = model.vertex_masses();
  parallel_blocks(mesh.vertex_count(), 64, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t u = begin; u < end; ++u) {
      for (std::uint32_t k = around.start[u]; k < around.start[u + 1]; ++k) {
        const std::size_t t = around.tets[k].index();
        const Tet& tet = mesh.tets[t];
        const auto a = static_cast<int>(std::find(tet.begin(), tet.end(), VertexId(u)) - tet.begin());
        for (int b = 0; b < 4; ++b)
          *matrix.find(u, tet[static_cast<std::size_t>(b)].index()) +=
              stiffness * stiffness_block(shapes[t], lames[t], a, b);
      }
      matrix.find(u, u)->diagonal().array() += inertia * masses[u];
    }
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

std::unique_ptr<WarpedBase> make_base(const BaseRequest& request) {
  const Model& model = request.model;
  const VertexTets around = vertex_tets(model.mesh());
  BlockMatrix matrix = pattern_of(model.mesh(), around, request.springs);
  add_tets(matrix, request, around);
  add_springs(matrix, request);
  auto base = std::make_unique<WarpedBase>();
  std::vector<std::uint8_t> active(model.fixed().size());
  std::transform(model.fixed().begin(), model.fixed().end(), active.begin(), [](std::uint8_t f) { return f == 0; });
  base->pattern = request.pattern ? request.pattern : std::make_shared<const FactorPattern>(analyse(matrix, active));
  base->factor = SparseFactor(base->pattern, matrix, active);
  base->single = FloatFactor(base->factor);
  base->row_of_slot.assign(active.size(), -1);
  std::uint32_t number = 0;
  for (std::size_t v = 0; v < active.size(); ++v)
    if (active[v]) base->row_of_slot[v] = static_cast<std::int32_t>(3 * base->pattern->position[number++]);
  std::vector<std::uint32_t> likely;
  for (const VertexId v : request.likely)
    if (base->row_of_slot[v.index()] >= 0) likely.push_back(static_cast<std::uint32_t>(base->row_of_slot[v.index()]));
  base->ready.add(base->factor, likely);
  return base;
}

}  // namespace calot
