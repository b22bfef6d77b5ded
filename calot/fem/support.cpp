#include "calot/fem/support.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numeric>

#include "calot/mesh/parts.h"

namespace calot {
namespace {

// Parts that share vertices, directly or through others: one rigid-body system each.
std::vector<std::vector<std::uint32_t>> clusters_of(const Parts& parts,
                                                    const std::vector<std::vector<std::uint32_t>>& parts_of_vertex) {
  std::vector<std::uint32_t> root(parts.count());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t p) {
    while (root[p] != p) p = root[p] = root[root[p]];
    return p;
  };
  for (const auto& list : parts_of_vertex)
    for (std::size_t k = 1; k < list.size(); ++k) {
      const std::uint32_t a = find(list[0]), b = find(list[k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  std::map<std::uint32_t, std::vector<std::uint32_t>> by_root;
  for (std::uint32_t p = 0; p < parts.count(); ++p) by_root[find(p)].push_back(p);
  std::vector<std::vector<std::uint32_t>> clusters;
  for (auto& [first, members] : by_root) clusters.push_back(std::move(members));
  return clusters;
}

// Rows of [I, −(x−c)×] / scale: the velocity of a point of a rigid body from (velocity of c, spin · scale).
Eigen::Matrix<double, 3, 6> point_velocity(const Vec3& x, const Vec3& centre, double scale) {
  const Vec3 r = (x - centre) / scale;
  Eigen::Matrix<double, 3, 6> rows;
  rows.leftCols<3>().setIdentity();
  rows.rightCols<3>() << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0;
  return rows;
}

Vec3 centre_of(const TetMesh& mesh, const std::vector<VertexId>& vertices) {
  Vec3 sum = Vec3::Zero();
  for (const VertexId v : vertices) sum += mesh.position(v);
  return sum / static_cast<double>(vertices.size());
}

double radius_of(const TetMesh& mesh, const std::vector<VertexId>& vertices, const Vec3& centre) {
  double radius = 0;
  for (const VertexId v : vertices) radius = std::max(radius, (mesh.position(v) - centre).norm());
  return radius;
}

std::string describe(const TetMesh& mesh, const Parts& parts, std::uint32_t part,
                     const Eigen::Matrix<double, 6, 1>& motion) {
  const std::string name = "the part of " + std::to_string(parts.tets[part].size()) + " tets around vertex " +
                           std::to_string(parts.vertices[part].front().value);
  const auto region = mesh.region_names.find(mesh.regions[parts.tets[part].front().index()]);
  const std::string where = region == mesh.region_names.end() ? name : name + " (" + region->second + ")";
  return where + (motion.tail<3>().norm() > 1e-3 * motion.head<3>().norm() ? " can turn about what holds it"
                                                                           : " can drift away");
}

// A free motion of one cluster, as (part, motion), or nothing.
std::string free_motion(const TetMesh& mesh, const Parts& parts, const std::vector<std::uint32_t>& cluster,
                        const std::vector<std::vector<std::uint32_t>>& parts_of_vertex,
                        const std::vector<std::uint8_t>& fixed) {
  const Eigen::Index size = 6 * static_cast<Eigen::Index>(cluster.size());
  std::map<std::uint32_t, Eigen::Index> column;
  std::vector<Vec3> centre;
  std::vector<double> scale;
  for (const std::uint32_t p : cluster) {
    column[p] = 6 * static_cast<Eigen::Index>(centre.size());
    centre.push_back(centre_of(mesh, parts.vertices[p]));
    scale.push_back(radius_of(mesh, parts.vertices[p], centre.back()));
  }
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(size, size);
  const auto velocity = [&](std::uint32_t p, VertexId v) {
    const auto k = static_cast<std::size_t>(column.at(p) / 6);
    return point_velocity(mesh.position(v), centre[k], scale[k]);
  };
  for (const std::uint32_t p : cluster)
    for (const VertexId v : parts.vertices[p]) {
      if (fixed[v.index()]) {
        const auto rows = velocity(p, v);
        gram.block<6, 6>(column[p], column[p]) += rows.transpose() * rows;
      }
      const std::uint32_t first = parts_of_vertex[v.index()].front();
      if (first == p) continue;
      const auto mine = velocity(p, v), others = velocity(first, v);
      gram.block<6, 6>(column[p], column[p]) += mine.transpose() * mine;
      gram.block<6, 6>(column[first], column[first]) += others.transpose() * others;
      gram.block<6, 6>(column[p], column[first]) -= mine.transpose() * others;
      gram.block<6, 6>(column[first], column[p]) -= others.transpose() * mine;
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  const double largest = std::max(1.0, solver.eigenvalues()(size - 1));
  if (solver.eigenvalues()(0) > 1e-12 * largest) return {};
  const Eigen::VectorXd mode = solver.eigenvectors().col(0);
  std::size_t most = 0;
  for (std::size_t k = 1; k < cluster.size(); ++k)
    if (mode.segment<6>(6 * static_cast<Eigen::Index>(k)).norm() >
        mode.segment<6>(6 * static_cast<Eigen::Index>(most)).norm())
      most = k;
  return describe(mesh, parts, cluster[most], mode.segment<6>(6 * static_cast<Eigen::Index>(most)));
}

}  // namespace

std::string unsupported_part(const TetMesh& mesh, const std::vector<std::uint8_t>& fixed) {
  const Parts parts = face_connected_parts(mesh);
  std::vector<std::vector<std::uint32_t>> parts_of_vertex(mesh.vertex_count());
  for (std::uint32_t p = 0; p < parts.count(); ++p)
    for (const VertexId v : parts.vertices[p]) parts_of_vertex[v.index()].push_back(p);
  for (const std::vector<std::uint32_t>& cluster : clusters_of(parts, parts_of_vertex)) {
    const bool anything_fixed = std::any_of(cluster.begin(), cluster.end(), [&](std::uint32_t p) {
      return std::any_of(parts.vertices[p].begin(), parts.vertices[p].end(),
                         [&](VertexId v) { return fixed[v.index()] != 0; });
    });
    if (!anything_fixed) {
      Eigen::Matrix<double, 6, 1> drift = Eigen::Matrix<double, 6, 1>::Zero();
      drift(0) = 1;
      return describe(mesh, parts, cluster.front(), drift);
    }
    if (std::string found = free_motion(mesh, parts, cluster, parts_of_vertex, fixed); !found.empty()) return found;
  }
  return {};
}

}  // namespace calot
