// Everything that instantiates CGAL's mesher lives in this file: it takes long to compile.
#include "calot/patient/cgal_mesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Random.h>
#include <CGAL/assertions_behaviour.h>
#include <CGAL/refine_mesh_3.h>
#include <CGAL/version_macros.h>

#include <algorithm>
#include <unordered_map>

#include "calot/base/error.h"

namespace calot {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

Vec3 to_vec(const Kernel::Point_3& p) {
  return {p.x(), p.y(), p.z()};
}
Kernel::Point_3 to_point(const Vec3& p) {
  return {p[0], p[1], p[2]};
}

/// A wanted edge length times a factor, as CGAL asks for sizes.
struct Sizing {
  using FT = Kernel::FT;
  const std::function<double(const Vec3&)>* edge;
  double factor;
  FT operator()(const Kernel::Point_3& p, int, const Domain::Index&) const { return factor * (*edge)(to_vec(p)); }
};

/// First points on the surfaces: rays from the seeds. CGAL's own start finds thin regions only by luck.
void insert_seeds(Complex& complex, const Domain& domain, const MeshingProblem& problem) {
  Triangulation& triangulation = complex.triangulation();
  const auto intersect = domain.construct_intersection_object();
  const double far = problem.box.diagonal().norm();
  std::vector<Vec3> taken;
  for (const Vec3& seed : problem.seeds)
    for (int side = 0; side < 6; ++side) {
      Vec3 target = seed;
      const double sign = side % 2 == 0 ? 1 : -1;
      target[side / 2] += sign * far;
      target = target.cwiseMax(problem.box.min()).cwiseMin(problem.box.max());
      const auto hit = intersect(Kernel::Segment_3(to_point(seed), to_point(target)));
      if (std::get<2>(hit) == 0) continue;
      const Vec3 place = to_vec(std::get<0>(hit));
      const double apart = problem.edge(place);
      if (std::any_of(taken.begin(), taken.end(), [&](const Vec3& t) { return (t - place).norm() < apart; })) continue;
      const auto vertex = triangulation.insert(Triangulation::Weighted_point(std::get<0>(hit)));
      if (vertex == Triangulation::Vertex_handle()) continue;
      taken.push_back(place);
      complex.set_dimension(vertex, 2);
      complex.set_index(vertex, std::get<1>(hit));
    }
}

TetMesh to_mesh(const Complex& complex) {
  TetMesh mesh;
  std::unordered_map<const void*, VertexId> number;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tet tet;
    for (int c = 0; c < 4; ++c) {
      const auto vertex = cell->vertex(c);
      const auto [entry, added] = number.try_emplace(&*vertex, VertexId(mesh.positions.size()));
      if (added) mesh.positions.push_back(to_vec(vertex->point().point()));
      tet[static_cast<std::size_t>(c)] = entry->second;
    }
    mesh.tets.push_back(tet);
    mesh.regions.push_back(complex.subdomain_index(cell));
  }
  return mesh;
}

}  // namespace

std::string cgal_version() {
  return CGAL_VERSION_STR;
}

TetMesh cgal_mesh(const MeshingProblem& problem) {
  CGAL::set_warning_handler([](const char*, const char*, const char*, int, const char*) {});  // its text goes to stderr
  CGAL::get_default_random() =
      CGAL::Random(0);  // CGAL draws from one generator per thread, which remembers earlier calls
  const CGAL::Bbox_3 box(problem.box.min()[0], problem.box.min()[1], problem.box.min()[2], problem.box.max()[0],
                         problem.box.max()[1], problem.box.max()[2]);
  const Domain domain([&](const Kernel::Point_3& p) { return problem.region(to_vec(p)); }, box,
                      CGAL::parameters::relative_error_bound = 1e-5);
  const Sizing cell{&problem.edge, 0.75}, facet{&problem.edge, 0.65}, distance{&problem.edge, 0.12};
  const Criteria criteria(CGAL::parameters::facet_angle = 28, CGAL::parameters::facet_size = facet,
                          CGAL::parameters::facet_distance = distance, CGAL::parameters::cell_radius_edge_ratio = 2.0,
                          CGAL::parameters::cell_size = cell);
  Complex complex;
  insert_seeds(complex, domain, problem);
  if (complex.triangulation().dimension() != 3) throw FailedError("mesh", "the regions are too small to be meshed");
  CGAL::refine_mesh_3(complex, domain, criteria, CGAL::parameters::no_reset_c3t3(), CGAL::parameters::no_perturb(),
                      CGAL::parameters::no_exude());
  return to_mesh(complex);
}

}  // namespace calot
