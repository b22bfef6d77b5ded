#include "calot/fem/model.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/fem/assembly.h"
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
  stiffness_scale_.assign(mesh_.tet_count(), 1.0);
  if (total_mass && (!(*total_mass > 0) || !std::isfinite(*total_mass)))
    throw InputError("total_mass", "must be > 0 kg", "leave it out to use density × volume");
  if (dynamics_.mass_lumping == MassLumping::uniform) {
    double mass = 0;
    for (std::size_t t = 0; t < mesh_.tet_count(); ++t)
      mass += material(TetId(t)).density * signed_volume(mesh_, TetId(t));
    uniform_share_ = total_mass.value_or(mass) / static_cast<double>(mesh_.vertex_count());
    shares_.assign(mesh_.vertex_count(), uniform_share_);
  } else if (total_mass) {
    throw InputError("total_mass", "needs mass_lumping = \"uniform\"", "leave it out or change mass_lumping");
  }
}

std::vector<double> Model::vertex_masses() const {
  if (dynamics_.mass_lumping == MassLumping::uniform) return shares_;
  std::vector<double> masses(mesh_.vertex_count(), 0.0);
  for (std::size_t t = 0; t < mesh_.tet_count(); ++t) {
    const double quarter = material(TetId(t)).density * signed_volume(mesh_, TetId(t)) / 4;
    for (const VertexId v : mesh_.tet(TetId(t))) masses[v.index()] += quarter;
  }
  return masses;
}

BlockMatrix Model::assemble(double mass_factor, double stiffness_factor) const {
  const detail::ElementSum sum(*this, mass_factor, stiffness_factor);
  BlockMatrix matrix = pattern_of(mesh_, vertex_tets(mesh_));
  for (std::size_t t = 0; t < mesh_.tet_count(); ++t) {
    const Tet& tet = mesh_.tets[t];
    const TetShape shape = detail::shape_of(mesh_, tet);
    const detail::ElementSum::Region& region = sum.region(mesh_.regions[t]);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b)
        *matrix.find(tet[a].index(), tet[b].index()) +=
            sum.block(region, stiffness_scale_[t], shape, static_cast<int>(a), static_cast<int>(b));
  }
  for (std::size_t v = 0; v < shares_.size(); ++v)
    matrix.find(v, v)->diagonal().array() += sum.own_diagonal(shares_[v]);
  return matrix;
}

BlockMatrix Model::stiffness() const {
  return assemble(0, 1);
}
BlockMatrix Model::step_stiffness() const {
  return assemble(dynamics_.mass_factor(), dynamics_.stiffness_factor());
}

bool Model::has_even_masses() const {
  return std::all_of(shares_.begin(), shares_.end(), [&](double share) { return share == uniform_share_; });
}
bool Model::has_scaled_stiffness() const {
  return std::any_of(stiffness_scale_.begin(), stiffness_scale_.end(), [](double scale) { return scale != 1; });
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
  // What every model has had from the start comes first, so that files written then are still recognised.
  const bool even = has_even_masses();
  const double values[] = {dynamics_.time_step, dynamics_.rayleigh_mass, dynamics_.rayleigh_stiffness,
                           even ? uniform_share_ : -1};
  append(bytes, values, 4);
  if (!even) append(bytes, shares_.data(), shares_.size());
  if (has_scaled_stiffness()) append(bytes, stiffness_scale_.data(), stiffness_scale_.size());
  return sha256(bytes);
}

void Model::set_vertex_masses(std::vector<double> masses) {
  if (dynamics_.mass_lumping != MassLumping::uniform)
    throw InputError("vertex_masses", "needs mass_lumping = \"uniform\"", "leave it out or change mass_lumping");
  if (masses.size() != mesh_.vertex_count())
    throw InputError("vertex_masses", "has " + std::to_string(masses.size()) + " values for " +
                                          std::to_string(mesh_.vertex_count()) + " vertices");
  if (!std::all_of(masses.begin(), masses.end(), [](double m) { return m > 0 && std::isfinite(m); }))
    throw InputError("vertex_masses", "must be finite and > 0 kg", "correct them");
  shares_ = std::move(masses);
}

}  // namespace calot
