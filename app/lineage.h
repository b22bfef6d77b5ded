// Several edits of a mesh, one after another, seen as one: what became of the mesh before, and where the mesh after
// comes from.
#pragma once
#include <utility>
#include <vector>

#include "calot/mesh/topology_edit.h"

namespace calot {

class Lineage {
 public:
  explicit Lineage(const TetMesh& mesh);
  /// Takes in the next edit.
  void follow(const Remap& remap);

  /// The new number of each old vertex; none() where it is gone.
  [[nodiscard]] const std::vector<VertexId>& vertex_to_new() const { return vertex_to_new_; }
  [[nodiscard]] std::size_t vertices_removed() const;
  [[nodiscard]] std::size_t vertices_added() const;
  [[nodiscard]] std::size_t vertices_moved() const;  ///< old ones that are still there, in another place
  [[nodiscard]] std::size_t tets_removed() const;
  [[nodiscard]] std::size_t tets_added() const;

  /// A new vertex as the weighted mean of old ones: the weights sum to 1, and positions, temperatures … of the old mesh
  /// carried over so are right at its place. A vertex that stayed where it was comes from itself alone.
  struct Share {
    VertexId old;
    double weight;  ///< 0 … 1
  };
  using Origin = std::vector<Share>;  // ascending by `old`
  [[nodiscard]] const std::vector<Origin>& origins() const { return origins_; }
  /// The new vertex is an old one that stayed where it was.
  [[nodiscard]] bool in_place(VertexId v) const;

 private:
  std::vector<VertexId> vertex_to_new_, vertex_to_old_;
  std::vector<TetId> tet_to_new_;
  std::size_t tets_now_;
  std::vector<Origin> origins_;  // of the vertices now
};

}  // namespace calot
