// The organ that benchmarks cut: a phantom's biliary tree, or a model of the caller's.
#pragma once
#include <vector>

#include "bench/bench.h"
#include "calot/cut/cut.h"
#include "calot/fem/model.h"

namespace calot::bench {

struct Organ {
  Model model;
  std::string duct;  ///< name or number of the region that is cut
  Vec3 middle;       ///< of the duct [m]
  Vec3 axis;         ///< the duct's long axis, unit, pointing away from the supports
  double length;     ///< of the duct along the axis [m]
};

/// `options.model` if given, else the phantom of seed 1 meshed to `vertices`: E 1 MPa, ν 0.45, ρ 1000, held at both
/// ends of the common bile duct, h = 20 ms, as in the paper.
Organ make_organ(const BenchOptions& options, std::size_t vertices = 2442, double time_step = 0.02);
/// The same phantom meshed to so many tets; `options.model` doesn't count.
Organ make_organ_of_tets(const BenchOptions& options, std::size_t tets, double time_step);
/// What there is to know about a model whose duct is to be cut. Throws InputError where it has none.
Organ organ_of(Model model);

/// Full transections of the duct at `count` places between 30 % and 70 % of its length, crumbs cleaned away. Only cuts
/// that leave the gallbladder's end without support are kept.
std::vector<Edit> transections(const Organ& organ, std::size_t count);

/// 3·vertices degrees of freedom, half of them at the face of the cut, half spread over the mesh.
std::vector<DofId> query_dofs(const StiffnessChange& change, std::size_t vertices_after, std::size_t count = 20);

/// A solid ball of cubes cut into tets, about `vertices` vertices: the compact organ of the growth benchmark.
TetMesh compact_organ(std::size_t vertices);
/// A branching tree of square tubes, about `vertices` vertices: the duct tree of the growth benchmark.
TetMesh duct_tree(std::size_t vertices);

}  // namespace calot::bench
