// The surfaces that touch: the tissue's, which moves and is cut, and still ones.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "calot/contact/tissue_contact.h"
#include "calot/mesh/surface.h"
#include "calot/mesh/topology_edit.h"

namespace calot {

namespace detail {
class BoxTree;
}

/// A boundary face of the tissue.
struct ContactTriangle {
  std::array<VertexId, 3> vertices;  ///< counter-clockwise from outside
  TetId tet;                         ///< behind it
  std::uint32_t face = 0;            ///< of the tet: opposite its corner `face`
  std::int32_t region = 0;
  friend bool operator==(const ContactTriangle&, const ContactTriangle&) = default;
};

/// The tissue's boundary, in order of (tet, face), with a tree of boxes for queries. Regions that are held still are in
/// it like all others.
class ContactSurface {
 public:
  explicit ContactSurface(const TetMesh& mesh);
  ~ContactSurface();
  ContactSurface(ContactSurface&&) noexcept;
  ContactSurface& operator=(ContactSurface&&) noexcept;

  /// Brings the surface up to date after an edit: afterwards it equals a new ContactSurface(mesh). Only the faces near
  /// the edit are decided anew. The tree is rebuilt at the next `refit`.
  void follow(const TetMesh& mesh, const Remap& remap);

  /// Takes the tissue's present positions and where each vertex is thought to move in this step (n, or empty: nowhere)
  /// [m]. Boxes hold both, and half of `margin` more on every side.
  void refit(std::span<const Vec3> positions, std::span<const Vec3> motion, double margin);

  [[nodiscard]] const std::vector<ContactTriangle>& triangles() const { return triangles_; }
  [[nodiscard]] const std::vector<Vec3>& normals() const { return normals_; }  ///< unit, of triangles; of last refit
  [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }  ///< n [m]
  [[nodiscard]] const std::vector<Vec3>& motion() const { return motion_; }        ///< n [m]
  /// Where a triangle's middle is in the rest shape, and its unit normal there.
  struct RestFace {
    Vec3 middle, normal;
  };
  [[nodiscard]] const std::vector<RestFace>& rest_faces() const { return rest_faces_; }
  [[nodiscard]] double largest_motion() const { return largest_motion_; }
  [[nodiscard]] const detail::BoxTree& tree() const { return *tree_; }
  /// The triangles at a vertex, ascending.
  [[nodiscard]] std::span<const std::uint32_t> around(VertexId v) const {
    return std::span(around_).subspan(start_[v.index()], start_[v.index() + 1] - start_[v.index()]);
  }

  /// The point of the surface nearest to p, and how far p is outside (< 0: inside) [m]. After `refit`.
  struct Nearest {
    std::uint32_t triangle = 0;
    Vec3 weights = Vec3::UnitX();
    double distance = 0;
  };
  [[nodiscard]] Nearest nearest(const Vec3& p) const;

 private:
  void index_vertices(std::size_t vertices);

  std::vector<ContactTriangle> triangles_;
  std::vector<std::uint32_t> start_, around_;  // triangles of each vertex, compressed rows
  std::vector<Vec3> normals_, positions_, motion_, rest_;
  std::vector<RestFace> rest_faces_;
  double largest_motion_ = 0;
  std::unique_ptr<detail::BoxTree> tree_;
  bool tree_is_stale_ = true;
};

/// A triangle surface that doesn't move: the abdominal wall, or an organ that isn't meshed.
class StillSurface {
 public:
  /// @param two_sided  an open sheet that holds tissue off on whichever side it is; else only its outside does
  /// Throws InputError for a triangle that names no vertex, or positions that aren't finite.
  StillSurface(Surface surface, double friction, bool two_sided);
  ~StillSurface();
  StillSurface(StillSurface&&) noexcept;
  StillSurface& operator=(StillSurface&&) noexcept;
  [[nodiscard]] const Surface& surface() const { return surface_; }
  [[nodiscard]] const std::vector<Vec3>& normals() const { return normals_; }  ///< of triangles, unit
  [[nodiscard]] double friction() const { return friction_; }
  [[nodiscard]] bool two_sided() const { return two_sided_; }
  [[nodiscard]] const detail::BoxTree& tree() const { return *tree_; }

 private:
  Surface surface_;
  std::vector<Vec3> normals_;
  double friction_;
  bool two_sided_;
  std::unique_ptr<detail::BoxTree> tree_;
};

}  // namespace calot
