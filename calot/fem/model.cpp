#include "calot/fem/model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/fem/support.h"
#include "calot/mesh/quality.h"

namespace calot {
namespace {

void check_material(std::int32_t region, const Material& m) {
  const std::string where = "material of region " + std::to_string(region);
  if (!(m.young > 0) || !std::isfinite(m.young))
    throw InputError(where, "young must be > 0 Pa", "give Young's modulus in Pa");
  if (!(m.poisson > -1 && m.poisson < 0.5))
    throw InputError(where, "poisson must lie between −1 and 0.5", "use e.g. 0.45");
  if (!(m.density > 0) || !std::isfinite(m.density))
    throw InputError(where, "density must be > 0 kg/m3", "use e.g. 1000");
}

void check_dynamics(const Dynamics& d) {
  const auto check = [](double value, const char* name) {
    if (!(value >= 0) || !std::isfinite(value)) throw InputError(name, "must be a finite number ≥ 0", "correct it");
  };
  check(d.time_step, "time_step");
  check(d.rayleigh_mass, "rayleigh_mass");
  check(d.rayleigh_stiffness, "rayleigh_stiffness");
}

// Pattern of the vertex graph: row u lists u and every vertex that shares a tet with it, ascending.
BlockMatrix pattern_of(const TetMesh& mesh, const VertexTets& around) {
  BlockMatrix matrix;
  matrix.row_start.assign(mesh.vertex_count() + 1, 0);
  std::vector<std::uint32_t> row;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    row.assign(1, static_cast<std::uint32_t>(v));
    for (std::uint32_t k = around.start[v]; k < around.start[v + 1]; ++k)
      for (const VertexId u : mesh.tet(around.tets[k])) row.push_back(u.value);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    matrix.column.insert(matrix.column.end(), row.begin(), row.end());
    matrix.row_start[v + 1] = static_cast<std::uint32_t>(matrix.column.size());
  }
  matrix.block.assign(matrix.column.size(), Mat3::Zero());
  return matrix;
}

TetShape shape_of(const TetMesh& mesh, TetId t) {
  const Tet& v = mesh.tet(t);
  return tet_shape(mesh.position(v[0]), mesh.position(v[1]), mesh.position(v[2]), mesh.position(v[3]));
}

// Appends raw bytes of numbers, for the fingerprint.
template <class T>
void append(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

}  // namespace

double Dynamics::mass_factor() const {
  return is_static() ? 0 : (1 + time_step * rayleigh_mass) / (time_step * time_step);
}

double Dynamics::stiffness_factor() const {
  return is_static() ? 1 : 1 + rayleigh_stiffness / time_step;
}

Model::Model(TetMesh mesh, std::map<std::int32_t, Material> materials, std::vector<std::uint8_t> fixed,
             Dynamics dynamics, std::optional<double> total_mass, Origin origin)
    : mesh_(std::move(mesh)),
      materials_(std::move(materials)),
      fixed_(std::move(fixed)),
      dynamics_(dynamics),
      origin_(std::move(origin)) {
  if (const MeshProblems problems = validate(mesh_); problems.fatal())
    throw InputError("mesh", problems.describe(), "repair the mesh");
  if (mesh_.tets.empty()) throw InputError("mesh", "has no tetrahedra", "give a volume mesh");
  if (fixed_.size() != mesh_.vertex_count())
    throw InputError("fixed", "has " + std::to_string(fixed_.size()) + " flags for " +
                                  std::to_string(mesh_.vertex_count()) + " vertices");
  for (const std::int32_t region : mesh_.regions)
    if (!materials_.contains(region))
      throw InputError("material", "region " + std::to_string(region) + " has none",
                       "add a [[material]] for it or for \"*\"");
  for (const auto& [region, material] : materials_) check_material(region, material);
  check_dynamics(dynamics_);
  if (total_mass && (!(*total_mass > 0) || !std::isfinite(*total_mass)))
    throw InputError("total_mass", "must be > 0 kg", "leave it out to use density × volume");
  if (dynamics_.mass_lumping == MassLumping::uniform) {
    double mass = 0;
    for (std::size_t t = 0; t < mesh_.tet_count(); ++t)
      mass += material(TetId(t)).density * signed_volume(mesh_, TetId(t));
    uniform_share_ = total_mass.value_or(mass) / static_cast<double>(mesh_.vertex_count());
  } else if (total_mass) {
    throw InputError("total_mass", "needs mass_lumping = \"uniform\"", "leave it out or change mass_lumping");
  }
}

std::vector<double> Model::vertex_masses() const {
  if (dynamics_.mass_lumping == MassLumping::uniform) return std::vector<double>(mesh_.vertex_count(), uniform_share_);
  std::vector<double> masses(mesh_.vertex_count(), 0.0);
  for (std::size_t t = 0; t < mesh_.tet_count(); ++t) {
    const double quarter = material(TetId(t)).density * signed_volume(mesh_, TetId(t)) / 4;
    for (const VertexId v : mesh_.tet(TetId(t))) masses[v.index()] += quarter;
  }
  return masses;
}

namespace {

// What each region contributes, looked up by tet.
class RegionTable {
 public:
  explicit RegionTable(const Model& model) {
    for (const auto& [region, material] : model.materials())
      entries_.push_back({region, lame(material), material.density});
  }
  struct Entry {
    std::int32_t region;
    Lame lame;
    double density;
  };
  [[nodiscard]] const Entry& of(std::int32_t region) const {
    for (const Entry& entry : entries_)  // a handful
      if (entry.region == region) return entry;
    return entries_.front();
  }

 private:
  std::vector<Entry> entries_;
};

// The one place where tets are summed into blocks: of row u, every block whose column is in the row's pattern, tets
// ascending. A fresh assembly and a row summed anew after a cut agree to the last bit because both come through here.
struct RowAssembler {
  const TetMesh& mesh;
  const VertexTets& around;
  const RegionTable& regions;
  double mass_factor, stiffness_factor, uniform_share;
  bool lumped_by_element;

  // Block (a, b) of Â_e of one tet.
  [[nodiscard]] Mat3 block(TetId t, const TetShape& shape, int a, int b) const {
    const RegionTable::Entry& region = regions.of(mesh.regions[t.index()]);
    Mat3 result = stiffness_factor * stiffness_block(shape, region.lame, a, b);
    if (a == b && lumped_by_element) result.diagonal().array() += mass_factor * (region.density * shape.volume / 4);
    return result;
  }
  // add(column vertex, block) is called once for each corner of each tet around u.
  template <class Add>
  void row(VertexId u, const TetShape* shapes, const Add& add) const {
    for (std::uint32_t k = around.start[u.index()]; k < around.start[u.index() + 1]; ++k) {
      const TetId t = around.tets[k];
      const Tet& tet = mesh.tet(t);
      const TetShape shape = shapes ? shapes[t.index()] : shape_of(mesh, t);
      const int a = static_cast<int>(std::find(tet.begin(), tet.end(), u) - tet.begin());
      for (int b = 0; b < 4; ++b) add(tet[static_cast<std::size_t>(b)], block(t, shape, a, b));
    }
  }
  // What a vertex has whatever tets it keeps.
  [[nodiscard]] double own_diagonal() const { return mass_factor * uniform_share; }
};

RowAssembler assembler_of(const Model& model, const TetMesh& mesh, const VertexTets& around, const RegionTable& regions,
                          double mass_factor, double stiffness_factor) {
  return {mesh,
          around,
          regions,
          mass_factor,
          stiffness_factor,
          model.uniform_share(),
          model.dynamics().mass_lumping == MassLumping::element};
}

}  // namespace

BlockMatrix Model::assemble(double mass_factor, double stiffness_factor) const {
  const VertexTets around = vertex_tets(mesh_);
  const RegionTable regions(*this);
  const RowAssembler assembler = assembler_of(*this, mesh_, around, regions, mass_factor, stiffness_factor);
  std::vector<TetShape> shapes(mesh_.tet_count());
  for (std::size_t t = 0; t < shapes.size(); ++t) shapes[t] = shape_of(mesh_, TetId(t));
  BlockMatrix matrix = pattern_of(mesh_, around);
  for (std::size_t u = 0; u < mesh_.vertex_count(); ++u) {
    assembler.row(VertexId(u), shapes.data(),
                  [&](VertexId v, const Mat3& block) { *matrix.find(u, v.index()) += block; });
    matrix.find(u, u)->diagonal().array() += assembler.own_diagonal();
  }
  return matrix;
}

BlockMatrix Model::stiffness() const {
  return assemble(0, 1);
}
BlockMatrix Model::step_stiffness() const {
  return assemble(dynamics_.mass_factor(), dynamics_.stiffness_factor());
}

std::string Model::fingerprint() const {
  std::string bytes;
  for (const Vec3& p : mesh_.positions) append(bytes, p.data(), 3);
  for (const Tet& t : mesh_.tets) append(bytes, t.data(), 4);
  append(bytes, mesh_.regions.data(), mesh_.regions.size());
  append(bytes, fixed_.data(), fixed_.size());
  for (const auto& [region, m] : materials_) {
    if (std::find(mesh_.regions.begin(), mesh_.regions.end(), region) == mesh_.regions.end()) continue;
    append(bytes, &region, 1);
    const double values[] = {m.young, m.poisson, m.density};
    append(bytes, values, 3);
  }
  const double values[] = {dynamics_.time_step, dynamics_.rayleigh_mass, dynamics_.rayleigh_stiffness, uniform_share_};
  append(bytes, values, 4);
  return sha256(bytes);
}

StiffnessChange Model::apply(const TopologyEdit& edit) {
  if (!edit.vertices.empty() || !edit.tets.empty())
    throw InputError("edit", "adds vertices or tets; only removal is supported by the compliance", "use mode remove");
  StiffnessChange change;
  const TetMesh before = mesh_;
  change.remap = calot::apply(mesh_, edit);
  change.struck = change.remap.orphaned;
  change.touched = change.remap.touched;

  std::vector<std::uint8_t> fixed(mesh_.vertex_count());
  for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = fixed_[change.remap.vertex_to_old[v].index()];
  fixed_ = std::move(fixed);

  std::vector<std::uint32_t> place(before.vertex_count(), ~0u);
  for (std::size_t k = 0; k < change.touched.size(); ++k)
    place[change.touched[k].index()] = static_cast<std::uint32_t>(k);

  // Σ Â_e of what goes, and which blocks that concerns.
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(change.touched.size());
  change.removed = Eigen::MatrixXd::Zero(size, size);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  const VertexTets unused;
  const RegionTable regions(*this);
  const RowAssembler assembler =
      assembler_of(*this, before, unused, regions, dynamics_.mass_factor(), dynamics_.stiffness_factor());
  for (const TetId t : edit.removed) {
    const Tet& tet = before.tet(t);
    const TetShape shape = shape_of(before, t);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const std::uint32_t i = place[tet[static_cast<std::size_t>(a)].index()],
                            j = place[tet[static_cast<std::size_t>(b)].index()];
        if (i == ~0u || j == ~0u) continue;
        change.removed.block<3, 3>(3 * Eigen::Index{i}, 3 * Eigen::Index{j}) += assembler.block(t, shape, a, b);
        pairs.emplace_back(i, j);
      }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  sum_rows(change, pairs);
  if (dynamics_.is_static()) change.unsupported = unsupported_part(mesh_, fixed_);
  return change;
}

void Model::sum_rows(StiffnessChange& change, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) const {
  const VertexTets around = vertex_tets(mesh_);
  const RegionTable regions(*this);
  const RowAssembler assembler =
      assembler_of(*this, mesh_, around, regions, dynamics_.mass_factor(), dynamics_.stiffness_factor());
  change.entries.reserve(pairs.size());
  std::vector<std::int32_t> entry_of(mesh_.vertex_count(), -1);  // of the row in hand
  for (std::size_t first = 0, last = 0; first < pairs.size(); first = last) {
    const std::uint32_t row = pairs[first].first;
    for (last = first; last < pairs.size() && pairs[last].first == row; ++last) {
      entry_of[change.remap.vertex_to_new[change.touched[pairs[last].second].index()].index()] =
          static_cast<std::int32_t>(change.entries.size());
      change.entries.push_back({row, pairs[last].second, Mat3::Zero()});
    }
    const VertexId u = change.remap.vertex_to_new[change.touched[row].index()];
    assembler.row(u, nullptr, [&](VertexId v, const Mat3& block) {
      if (entry_of[v.index()] >= 0) change.entries[static_cast<std::size_t>(entry_of[v.index()])].block += block;
    });
    change.entries[static_cast<std::size_t>(entry_of[u.index()])].block.diagonal().array() += assembler.own_diagonal();
    for (std::size_t k = first; k < last; ++k)
      entry_of[change.remap.vertex_to_new[change.touched[pairs[k].second].index()].index()] = -1;
  }
}

}  // namespace calot
