// How good a mesh is, and whether it is a mesh at all.
#pragma once
#include <string>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// Quality of a set of tets. Angles in degrees, lengths and volumes in metres.
struct Quality {
  std::size_t vertices = 0, tets = 0;
  double min_dihedral = 0, max_dihedral = 0;         ///< [°]
  double min_edge = 0, max_edge = 0, mean_edge = 0;  ///< [m]
  double min_volume = 0, volume = 0;                 ///< [m³], smallest tet and sum
  double min_radius_ratio = 0;                       ///< 3·inradius/circumradius, 1 for a regular tet
};
Quality quality(const TetMesh& mesh);
Quality quality(const TetMesh& mesh, std::int32_t region);

/// Everything wrong with a mesh; empty when it is sound.
struct MeshProblems {
  std::vector<TetId> inverted;         ///< volume < 0
  std::vector<TetId> flat;             ///< volume 0 (relative to the longest edge cubed, 1e-14)
  std::vector<TetId> repeated_vertex;  ///< a tet that names a vertex twice
  std::vector<TetId> out_of_range;     ///< a vertex number ≥ n
  std::vector<TetId> duplicate;        ///< same four vertices, or places, as an earlier tet
  std::vector<VertexId> not_finite;    ///< NaN, infinite, or beyond 1e100 (volumes overflow)
  std::vector<VertexId> coincident;    ///< at exactly the place of an earlier vertex, as the lips of a cut are
  std::vector<VertexId> unused;        ///< no tet uses it
  std::vector<TetId> overfull_face;    ///< a tet with a face that three or more tets share, by number or by place
  bool sizes_differ = false;           ///< `regions` and `tets` differ in length
  [[nodiscard]] bool fatal() const;    ///< anything but coincident or unused vertices
  /// One line, counts and the first few numbers: "2 inverted tets (17, 40)". Empty when sound.
  [[nodiscard]] std::string describe() const;
};
MeshProblems validate(const TetMesh& mesh);

/// Turns inverted tets around by exchanging two vertices; returns how many.
std::size_t orient(TetMesh& mesh);

}  // namespace calot
