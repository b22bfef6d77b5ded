#include "bench/organ.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "calot/base/error.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/parts.h"
#include "calot/patient/mesher.h"
#include "calot/patient/phantom.h"

namespace calot::bench {
namespace {

Progress& progress_of(const BenchOptions& options) {
  static Progress silent;
  return options.progress ? *options.progress : silent;
}

// With fewer vertices than this a mesh can't follow a 3 mm duct: the gallbladder alone is meshed then, and cut across.
constexpr std::size_t least_for_ducts = 390;

// Both ends of the common bile duct; of a gallbladder alone its lower end.
std::vector<std::uint8_t> supports(const TetMesh& mesh, const Phantom& phantom, bool with_ducts) {
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  if (!with_ducts) {
    double low = 1e300, high = -1e300;
    for (const Vec3& p : mesh.positions) low = std::min(low, p.z()), high = std::max(high, p.z());
    for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = mesh.positions[v].z() < low + 0.15 * (high - low);
    return fixed;
  }
  const auto line = std::find_if(phantom.lines.begin(), phantom.lines.end(),
                                 [](const Centreline& d) { return d.name == "common bile duct"; });
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (mesh.regions[t] != label_of(Structure::common_bile_duct)) continue;
    for (const VertexId v : mesh.tets[t])
      for (const Vec3& end : {line->points.front(), line->points.back()})
        if ((mesh.position(v) - end).norm() < 5e-3) fixed[v.index()] = 1;
  }
  return fixed;
}

Model phantom_model(const BenchOptions& options, MesherOptions mesher, double time_step) {
  const Phantom phantom = make_biliary_tree(1, 0.6e-3, options.progress);
  const bool with_ducts = mesher.tets > 0 || mesher.vertices >= least_for_ducts;
  if (!with_ducts) mesher.labels = {label_of(Structure::gallbladder)};
  LabelMesh meshed = mesh_labels(phantom.labels, mesher, progress_of(options));
  std::vector<std::uint8_t> fixed = supports(meshed.mesh, phantom, with_ducts);
  std::map<std::int32_t, Material> materials;
  for (const std::int32_t region : meshed.mesh.regions) materials[region] = Material{};
  Dynamics dynamics;
  dynamics.time_step = time_step;
  return Model(std::move(meshed.mesh), std::move(materials), std::move(fixed), dynamics);
}

// The region to cut: the one named so, or the paper mesh's number.
std::string duct_of(const Model& model) {
  for (const auto& [region, name] : model.mesh().region_names)
    if (name == "cystic duct") return name;
  if (std::find(model.mesh().regions.begin(), model.mesh().regions.end(), 3) != model.mesh().regions.end()) return "3";
  if (model.mesh().region_names.size() == 1) return "*";
  throw InputError("--model", "has no region named \"cystic duct\" nor numbered 3", "name the region to cut so");
}

}  // namespace

Organ make_organ(const BenchOptions& options, std::size_t vertices, double time_step) {
  if (!options.model.empty()) return organ_of(load_model(options.model));
  MesherOptions mesher;
  mesher.vertices = vertices;
  return organ_of(phantom_model(options, mesher, time_step));
}

Organ make_organ_of_tets(const BenchOptions& options, std::size_t tets, double time_step) {
  MesherOptions mesher;
  mesher.tets = tets;
  return organ_of(phantom_model(options, mesher, time_step));
}

Organ organ_of(Model model) {
  Organ organ{std::move(model), {}, {}, {}, 0};
  organ.duct = duct_of(organ.model);
  const TetMesh& mesh = organ.model.mesh();
  const std::vector<std::int32_t> regions = regions_matching(mesh, organ.duct, "duct");
  std::set<VertexId> vertices_of_duct;
  Vec3 held = Vec3::Zero();
  double held_count = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (std::find(regions.begin(), regions.end(), mesh.regions[t]) != regions.end())
      vertices_of_duct.insert(mesh.tets[t].begin(), mesh.tets[t].end());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (organ.model.is_fixed(VertexId(v))) held += mesh.positions[v], held_count += 1;
  organ.middle.setZero();
  for (const VertexId v : vertices_of_duct) organ.middle += mesh.position(v);
  organ.middle /= static_cast<double>(vertices_of_duct.size());
  Mat3 spread = Mat3::Zero();
  for (const VertexId v : vertices_of_duct)
    spread += (mesh.position(v) - organ.middle) * (mesh.position(v) - organ.middle).transpose();
  organ.axis = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(2);
  if (held_count > 0 && organ.axis.dot(organ.middle - held / held_count) < 0) organ.axis = -organ.axis;
  double low = 0, high = 0;
  for (const VertexId v : vertices_of_duct) {
    const double along = organ.axis.dot(mesh.position(v) - organ.middle);
    low = std::min(low, along);
    high = std::max(high, along);
  }
  organ.length = high - low;
  return organ;
}

std::vector<Edit> transections(const Organ& organ, std::size_t count) {
  std::vector<Edit> cuts;
  for (std::size_t k = 0; k < count; ++k) {
    const double along = (0.3 + 0.4 * (static_cast<double>(k) + 0.5) / static_cast<double>(count) - 0.5) * organ.length;
    Edit edit = cut(organ.model.mesh(), Plane{organ.middle + along * organ.axis, organ.axis}, {organ.duct, true});
    TetMesh after = organ.model.mesh();
    const Remap remap = apply(after, edit);
    const Parts parts = face_connected_parts(after);
    std::vector<std::uint8_t> held(parts.count(), 0);
    for (std::size_t p = 0; p < parts.count(); ++p)
      for (const VertexId v : parts.vertices[p])
        if (organ.model.is_fixed(remap.vertex_to_old[v.index()])) held[p] = 1;
    if (std::find(held.begin(), held.end(), 0) != held.end()) cuts.push_back(std::move(edit));
  }
  if (cuts.empty()) throw FailedError("", "no plane across the duct's axis severs it", "use another mesh");
  return cuts;
}

std::vector<DofId> query_dofs(const StiffnessChange& change, std::size_t vertices_after, std::size_t count) {
  std::vector<DofId> dofs;
  const auto add = [&](VertexId v) {
    for (int axis = 0; axis < 3; ++axis) dofs.push_back(dof_of(v, axis));
  };
  for (std::size_t k = 0; k < count / 2; ++k)
    add(change.remap.vertex_to_new[change.touched[k * change.touched.size() / (count / 2)].index()]);
  for (std::size_t k = count / 2; k < count; ++k) add(VertexId(k * 7919 % vertices_after));
  return dofs;
}

namespace {

// The cells of a grid for which `inside` holds, each cut into six tets around the same diagonal; 2 mm cells.
TetMesh grid_mesh(int nx, int ny, int nz, const std::function<bool(int, int, int)>& inside) {
  constexpr int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  std::vector<std::uint32_t> number(
      static_cast<std::size_t>(nx + 1) * static_cast<std::size_t>(ny + 1) * static_cast<std::size_t>(nz + 1), ~0u);
  TetMesh mesh;
  const auto vertex = [&](const std::array<int, 3>& at) {
    std::uint32_t& n = number[static_cast<std::size_t>(at[0] + (nx + 1) * (at[1] + (ny + 1) * at[2]))];
    if (n == ~0u) {
      n = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(2e-3 * Vec3(at[0], at[1], at[2]));
    }
    return VertexId(n);
  };
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        if (!inside(i, j, k)) continue;
        for (const auto& path : paths) {
          std::array<int, 3> at{i, j, k};
          Tet tet{vertex(at)};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(path[step])];
            tet[step + 1] = vertex(at);
          }
          if (signed_volume(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]),
                            mesh.position(tet[3])) < 0)
            std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
          mesh.regions.push_back(1);
        }
      }
  return mesh;
}

}  // namespace

TetMesh compact_organ(std::size_t vertices) {
  const double radius = std::cbrt(static_cast<double>(vertices) * 3 / (4 * 3.14159265358979)) - 0.35;
  const int n = 2 * static_cast<int>(std::ceil(radius)) + 1;
  const double centre = n / 2.0;
  return grid_mesh(n, n, n, [&](int i, int j, int k) {
    return std::hypot(i + 0.5 - centre, j + 0.5 - centre, k + 0.5 - centre) <= radius;
  });
}

TetMesh duct_tree(std::size_t vertices) {
  // A trunk along z with alternating side branches along x and y, all four cells wide: 25 vertices a layer.
  const int layers = std::max(8, static_cast<int>(std::lround(static_cast<double>(vertices) / 25)));
  const int side = std::max(4, static_cast<int>(std::sqrt(static_cast<double>(layers) / 2)));
  const int branch_every = 12, trunk = std::max(8, layers * branch_every / (branch_every + 2 * side));
  const int n = 4 + 2 * side, middle = side;
  return grid_mesh(n, n, trunk, [&](int i, int j, int k) {
    const bool in_x = i >= middle && i < middle + 4, in_y = j >= middle && j < middle + 4;
    if (in_x && in_y) return true;
    const bool branch = k % branch_every < 4;
    return branch && ((k / branch_every) % 2 == 0 ? in_y : in_x);
  });
}

}  // namespace calot::bench
