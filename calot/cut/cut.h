// Blade geometry → what to remove. A cut only decides; nothing changes until the edit is applied.
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "calot/mesh/parts.h"
#include "calot/mesh/topology_edit.h"

namespace calot {

/// An unbounded plane: a point on it [m] and a normal of any length > 0; the normal points to the upper side.
struct Plane {
  Vec3 point, normal;
};

/// A flat rectangular blade: centre [m], normal, the direction of its length (made orthogonal to the normal), and its
/// full length along that direction and width across it [m].
struct BladePatch {
  Vec3 centre, normal, along;
  double length, width;
};

using Blade = std::variant<Plane, BladePatch>;

struct CutOptions {
  std::string region = "*";  ///< only tets of this region (name or number; "*" is all)
  bool clean = false;        ///< also remove hinged and isolated tets that the cut leaves hanging
};

/// What a cut found; numbers are of the mesh before it.
struct CutReport {
  std::size_t crossed = 0;          ///< tets with vertices strictly on both sides, inside the blade
  std::size_t under_the_plane = 0;  ///< lower-side tets removed because a face in the plane joined the parts
  std::size_t cleaned = 0;          ///< hanging tets removed on request
  std::vector<TetId> hanging;       ///< tets left hanging by a vertex or an edge, or alone (kept unless `clean`)
  std::vector<std::string> notes;   ///< sentences for the summary and the log
};

/// A topology edit and how it came about.
struct Edit : TopologyEdit {
  CutReport report;
};

/// The tets that blades remove: those with vertices strictly on both sides (exact predicate), within the blade's
/// extent and the region. Where vertices lie on the plane and the parts stay joined through faces in it, the lower-side
/// tets touching it by a face go too. Nothing to remove gives an empty edit and a note.
/// Throws InputError for a zero or non-finite normal, point or extent, or an unknown region.
Edit cut(const TetMesh& mesh, const Blade& blade, const CutOptions& options = {});
Edit cut(const TetMesh& mesh, const std::vector<Blade>& blades, const CutOptions& options = {});

/// Exact sign of (x − p)·n for the doubles given: −1, 0 or 1, whatever the magnitudes (no overflow assumed).
int side_of_plane(const Vec3& x, const Vec3& p, const Vec3& n);

}  // namespace calot
