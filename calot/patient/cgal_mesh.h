// The one door to CGAL's mesher (Mesh_3), which takes long to compile: nothing of CGAL is seen here.
#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// What is meshed.
struct MeshingProblem {
  std::function<int(const Vec3&)> region;   ///< of a point [m]; 0 outside
  std::function<double(const Vec3&)> edge;  ///< wanted edge length at a point [m]; may throw to stop the work
  Eigen::AlignedBox3d box;                  ///< holds every region, with room around it [m]
  std::vector<Vec3> seeds;                  ///< points inside the regions; every region needs some, thin ones too
};

/// Meshes the regions conformingly by Delaunay refinement. Slivers are left in (mesh/improve.h removes them). The same
/// problem gives the same mesh. Tets are positively oriented; regions as in the problem. Source: [Jamin2015] CGALmesh;
/// CGAL 5.5, 3D Mesh Generation.
TetMesh cgal_mesh(const MeshingProblem& problem);

/// CGAL's version, "5.5.1".
std::string cgal_version();

}  // namespace calot
