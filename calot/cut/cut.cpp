#include "calot/cut/cut.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "calot/base/error.h"
#include "calot/cut/blade.h"
#include "calot/cut/hanging.h"

namespace calot {
namespace {

using Sides = std::vector<std::int8_t>;  // n, side of each vertex

/// Which tets are still there, and which may go.
struct Selection {
  std::vector<std::uint8_t> alive, allowed;  // m
};

Selection start_selection(const TetMesh& mesh, const std::string& region) {
  const std::vector<std::int32_t> regions = regions_matching(mesh, region, "region");
  Selection selection;
  selection.alive.assign(mesh.tet_count(), 1);
  selection.allowed.resize(mesh.tet_count());
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    selection.allowed[t] = std::find(regions.begin(), regions.end(), mesh.regions[t]) != regions.end() ? 1 : 0;
  return selection;
}

Sides sides_of_vertices(const TetMesh& mesh, const detail::ReadyBlade& blade) {
  Sides sides(mesh.vertex_count());
  for (std::size_t v = 0; v < sides.size(); ++v) sides[v] = static_cast<std::int8_t>(blade.side(mesh.positions[v]));
  return sides;
}

std::array<int, 4> corner_sides(const Tet& tet, const Sides& sides) {
  return {sides[tet[0].index()], sides[tet[1].index()], sides[tet[2].index()], sides[tet[3].index()]};
}

/// Takes the tets that the blade crosses; returns how many.
std::size_t take_crossed(const TetMesh& mesh, const detail::ReadyBlade& blade, const Sides& sides,
                         Selection& selection) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (selection.alive[t] == 0 || selection.allowed[t] == 0) continue;
    const Tet& tet = mesh.tets[t];
    const std::array<int, 4> side = corner_sides(tet, sides);
    const auto [low, high] = std::minmax_element(side.begin(), side.end());
    if (*low >= 0 || *high <= 0) continue;
    const std::array<Vec3, 4> corners{mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]),
                                      mesh.position(tet[3])};
    if (!blade.reaches_section(corners, side)) continue;
    selection.alive[t] = 0;
    ++count;
  }
  return count;
}

/// A live tet with a face in the plane.
struct FaceInPlane {
  std::array<std::uint32_t, 3> key;  // the face's vertices, ascending
  std::int8_t side;                  // of the fourth vertex
  std::uint32_t tet;
  friend auto operator<=>(const FaceInPlane&, const FaceInPlane&) = default;
};

std::vector<FaceInPlane> faces_in_plane(const TetMesh& mesh, const Sides& sides, const Selection& selection) {
  std::vector<FaceInPlane> faces;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (selection.alive[t] == 0) continue;
    const std::array<int, 4> side = corner_sides(mesh.tets[t], sides);
    if (std::count(side.begin(), side.end(), 0) != 3) continue;
    FaceInPlane face{{}, 0, static_cast<std::uint32_t>(t)};
    std::size_t k = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      if (side[c] == 0)
        face.key[k++] = mesh.tets[t][c].value;
      else
        face.side = static_cast<std::int8_t>(side[c]);
    }
    std::sort(face.key.begin(), face.key.end());
    faces.push_back(face);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

struct UnderThePlane {
  std::size_t taken = 0;    // lower-side tets that went
  std::size_t outside = 0;  // joined faces whose lower tet lies outside the region
};

/// Where a face in the plane joins a tet below to one above, takes the lower one.
UnderThePlane take_under_the_plane(const TetMesh& mesh, const detail::ReadyBlade& blade, const Sides& sides,
                                   Selection& selection) {
  UnderThePlane result;
  const std::vector<FaceInPlane> faces = faces_in_plane(mesh, sides, selection);
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    // Sorted by side within a face: the lower tet comes first.
    if (faces[i].key != faces[i + 1].key || faces[i].side >= 0 || faces[i + 1].side <= 0) continue;
    const auto& key = faces[i].key;
    if (!blade.reaches_triangle({mesh.positions[key[0]], mesh.positions[key[1]], mesh.positions[key[2]]})) continue;
    if (selection.allowed[faces[i].tet] == 0) {
      result.outside += selection.allowed[faces[i + 1].tet];
    } else if (selection.alive[faces[i].tet] != 0) {  // a tet has one face in the plane at most, so this always holds
      selection.alive[faces[i].tet] = 0;
      ++result.taken;
    }
  }
  return result;
}

std::vector<TetId> removed_tets(const Selection& selection) {
  std::vector<TetId> removed;
  for (std::size_t t = 0; t < selection.alive.size(); ++t)
    if (selection.alive[t] == 0) removed.emplace_back(t);
  return removed;
}

std::string tetrahedra(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " tetrahedron" : " tetrahedra");
}

void note_blade(const std::string& name, std::size_t crossed, const UnderThePlane& under, CutReport& report) {
  report.crossed += crossed;
  report.under_the_plane += under.taken;
  if (crossed == 0 && under.taken == 0) report.notes.push_back(name + " cuts nothing");
  if (under.taken > 0)
    report.notes.push_back(name + ": vertices lie on it and faces in it joined the parts, so " +
                           tetrahedra(under.taken) + " below it went too");
  if (under.outside > 0)
    report.notes.push_back(name + ": " + std::to_string(under.outside) +
                           " faces in it still join the parts, because the tetrahedra below are outside the region");
}

/// Finds what hangs and, on request, takes it too: whole pieces, and only those that lie in the region altogether.
void deal_with_hanging(const TetMesh& mesh, const std::vector<Sides>& sides, bool clean, Selection& selection,
                       Edit& edit) {
  CutReport& report = edit.report;
  const auto pieces = detail::hanging_pieces(mesh, edit.removed, sides);
  for (const std::vector<TetId>& piece : pieces) {
    report.hanging.insert(report.hanging.end(), piece.begin(), piece.end());
    const bool may_go =
        std::all_of(piece.begin(), piece.end(), [&](TetId t) { return selection.allowed[t.index()] != 0; });
    if (!clean || !may_go) continue;
    for (const TetId t : piece) selection.alive[t.index()] = 0;
    report.cleaned += piece.size();
  }
  std::sort(report.hanging.begin(), report.hanging.end());
  if (!pieces.empty())
    report.notes.push_back(tetrahedra(report.hanging.size()) + " left hanging by a vertex or an edge, or alone" +
                           (clean ? "; " + std::to_string(report.cleaned) + " of them cleaned away" : ""));
  edit.removed = removed_tets(selection);
  if (std::string hinged = detail::describe_hinges(mesh, edit.removed); !hinged.empty())
    report.notes.push_back(std::move(hinged));
}

}  // namespace

Edit cut(const TetMesh& mesh, const Blade& blade, const CutOptions& options) {
  return cut(mesh, std::vector<Blade>{blade}, options);
}

Edit cut(const TetMesh& mesh, const std::vector<Blade>& blades, const CutOptions& options) {
  Selection selection = start_selection(mesh, options.region);
  Edit edit;
  std::vector<Sides> sides;
  // One blade after another, so that the result is that of as many cuts.
  for (std::size_t b = 0; b < blades.size(); ++b) {
    const std::string name = "blade " + std::to_string(b + 1);
    const detail::ReadyBlade blade(blades[b], name);
    sides.push_back(sides_of_vertices(mesh, blade));
    const std::size_t crossed = take_crossed(mesh, blade, sides.back(), selection);
    note_blade(name, crossed, take_under_the_plane(mesh, blade, sides.back(), selection), edit.report);
  }
  edit.removed = removed_tets(selection);
  if (edit.removed.empty())
    edit.report.notes.emplace_back("nothing is removed: no blade crosses a tetrahedron of the region");
  else
    deal_with_hanging(mesh, sides, options.clean, selection, edit);
  return edit;
}

}  // namespace calot
