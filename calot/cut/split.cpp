#include "calot/cut/split.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "calot/base/error.h"
#include "calot/cut/separate.h"
#include "calot/cut/split_plan.h"
#include "calot/cut/tet_angles.h"
#include "calot/mesh/tet_faces.h"

namespace calot {
namespace {

using detail::FaceKey;
using detail::Meeting;
using detail::SplitPatch;
using detail::SplitPlan;
using detail::SweptPlane;

void check(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> current, const SplitOptions& options) {
  if (current.size() != mesh.vertex_count() || around.start.size() != mesh.vertex_count() + 1)
    throw InputError("split", "positions or tets around vertices don't fit the mesh", "give one for each vertex");
  if (!options.fixed.empty() && options.fixed.size() != mesh.vertex_count())
    throw InputError("split", "fixed has another size than the mesh has vertices", "give one flag for each vertex");
  if (!(options.flatness > 0) || !(options.margin >= 0) || !std::isfinite(options.flatness + options.margin))
    throw InputError("split", "flatness must be a length > 0 and margin one ≥ 0", "give metres");
  if (!(options.smallest_angle >= 0 && options.smallest_angle <= 60))
    throw InputError("split", "smallest_angle must be within 0 … 60 degrees", "use 3");
  if (options.stroke == nullptr) return;
  for (const std::vector<VertexId>* list : {&options.stroke->front, &options.stroke->lips}) {
    if (!list->empty() && list->back().index() >= mesh.vertex_count())
      throw InputError("split", "the stroke names a vertex that doesn't exist", "bring it up to date with follow()");
    if (!std::is_sorted(list->begin(), list->end()))
      throw InputError("split", "the stroke's vertices are not ascending", "bring it up to date with follow()");
  }
}

/// Ascending and unique; a vertex that was doubled is no longer at the front.
void tidy(Stroke& stroke) {
  for (std::vector<VertexId>* list : {&stroke.front, &stroke.lips}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  std::erase_if(stroke.front,
                [&](VertexId v) { return std::binary_search(stroke.lips.begin(), stroke.lips.end(), v); });
}

/// A face of a piece, all of whose corners lie on the cut.
struct CutFace {
  FaceKey key;
  std::uint32_t piece;
  std::uint32_t opposite;  // the piece's fourth corner
  friend auto operator<=>(const CutFace&, const CutFace&) = default;
};

/// Carries a plan out: bisects, finds the faces that open, separates, and writes the edit.
class Splitter {
 public:
  Splitter(const TetMesh& mesh, const SplitPatch& patch, const SplitPlan& plan, const SweptPlane& blade,
           const SplitOptions& options)
      : mesh_(mesh), patch_(patch), plan_(plan), blade_(blade), options_(options) {}

  SplitEdit run() {
    bisect();
    mark_corners();
    const std::vector<FaceKey> open = faces_to_open();
    edit_.report.separated = open.size();
    measure(open);
    origins_ = detail::separate_fans(pieces_, open, static_cast<std::uint32_t>(fresh_.size()));
    edit_.report.copies = origins_.size();
    write_vertices();
    write_tets();
    write_stroke();
    return std::move(edit_);
  }

 private:
  void bisect() {
    detail::Pieces pieces;
    for (std::uint32_t t = 0; t < patch_.tet.size(); ++t) {
      plan_.pieces_of(t, pieces);
      pieces_.insert(pieces_.end(), pieces.begin(), pieces.end());
      parent_.insert(parent_.end(), pieces.size(), t);
    }
  }

  /// Which corners this sweep put on the cut, and which lie on it since earlier.
  void mark_corners() {
    const std::size_t n = patch_.vertex.size();
    fresh_.assign(n + patch_.edges.size(), 0);
    on_cut_.assign(fresh_.size(), 0);
    for (std::uint32_t v = 0; v < patch_.core; ++v) {
      const Meeting meeting = plan_.meeting(v);
      const bool in_plane = patch_.side[v] == 0 && blade_.covers(patch_.now[v]);
      fresh_[v] = meeting == Meeting::taken || meeting == Meeting::slid || in_plane ? 1 : 0;
      on_cut_[v] = fresh_[v] != 0 || patch_.front[v] != 0 ? 1 : 0;
    }
    for (std::uint32_t e = 0; e < patch_.edges.size(); ++e) on_cut_[n + e] = fresh_[n + e] = plan_.bisected(e) ? 1 : 0;
  }

  [[nodiscard]] double height(std::uint32_t corner) const { return blade_.height(plan_.now(corner)); }

  /// Which side of the cut a piece lies on, from a face of it in the cut; 0 if all its corners are on the cut.
  [[nodiscard]] int side_of(const CutFace& face) const {
    if (on_cut_[face.opposite] != 0) return 0;
    const auto& [a, b, c] = face.key;
    if (fresh_[a] != 0 && fresh_[b] != 0 && fresh_[c] != 0 && patch_.side[face.opposite] != 0 && !on_lip(face.opposite))
      return patch_.side[face.opposite];
    const Vec3 centre = (plan_.now(a) + plan_.now(b) + plan_.now(c)) / 3;
    Vec3 normal = (plan_.now(b) - plan_.now(a)).cross(plan_.now(c) - plan_.now(a));
    if (normal.dot(blade_.normal()) < 0) normal = -normal;
    return normal.dot(plan_.now(face.opposite) - centre) < 0 ? -1 : 1;
  }

  /// A face with corners from earlier sweeps belongs to this cut only if it lies about as the blade does.
  [[nodiscard]] bool lies_along(const FaceKey& key) const {
    const auto& [a, b, c] = key;
    if (std::max({std::abs(height(a)), std::abs(height(b)), std::abs(height(c))}) <= 1.5 * patch_.flatness) return true;
    const Vec3 u = plan_.now(b) - plan_.now(a), v = plan_.now(c) - plan_.now(a);
    return std::abs(u.cross(v).normalized().dot(blade_.normal())) >= 0.5;
  }

  /// Faces with all corners on the cut; with `lips`, those that have corners on the stroke's lips among them.
  std::vector<CutFace> faces_on_cut(bool lips) const {
    std::vector<CutFace> faces;
    const auto counts = [&](std::uint32_t corner) { return on_cut_[corner] != 0 || (lips && on_lip(corner)); };
    for (std::uint32_t p = 0; p < pieces_.size(); ++p)
      for (std::size_t f = 0; f < 4; ++f) {
        const auto& tet = pieces_[p];
        const auto& c = detail::face_corners[f];
        if (!counts(tet[c[0]]) || !counts(tet[c[1]]) || !counts(tet[c[2]])) continue;
        if (lips && !on_lip(tet[c[0]]) && !on_lip(tet[c[1]]) && !on_lip(tet[c[2]])) continue;
        const FaceKey key = detail::face_key(tet[c[0]], tet[c[1]], tet[c[2]]);
        if (lies_along(key)) faces.push_back({key, p, tet[f]});
      }
    std::sort(faces.begin(), faces.end());
    return faces;
  }

  /// Sides of the pieces that have faces on the cut. A piece with all corners on it goes with its neighbours where they
  /// agree, and by its centroid where they don't.
  std::vector<std::int8_t> sides_of_pieces(const std::vector<CutFace>& faces) const {
    std::vector<std::int8_t> side(pieces_.size(), 0);
    std::vector<std::uint32_t> flat;
    for (const CutFace& face : faces) {
      side[face.piece] = static_cast<std::int8_t>(side_of(face));
      if (side[face.piece] == 0) flat.push_back(face.piece);
    }
    std::sort(flat.begin(), flat.end());
    flat.erase(std::unique(flat.begin(), flat.end()), flat.end());
    while (!flat.empty()) {
      std::vector<std::array<bool, 2>> beside(flat.size(), {false, false});
      const auto look = [&](std::uint32_t piece, std::uint32_t neighbour) {
        const auto at = std::lower_bound(flat.begin(), flat.end(), piece);
        if (at == flat.end() || *at != piece || side[neighbour] == 0) return;
        beside[static_cast<std::size_t>(at - flat.begin())][side[neighbour] > 0 ? 1 : 0] = true;
      };
      for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
        if (faces[i].key != faces[i + 1].key) continue;
        look(faces[i].piece, faces[i + 1].piece);
        look(faces[i + 1].piece, faces[i].piece);
      }
      std::vector<std::uint32_t> left;
      for (std::size_t i = 0; i < flat.size(); ++i) {
        const auto [below, above] = beside[i];
        if (below != above)
          side[flat[i]] = above ? 1 : -1;
        else if (below)
          side[flat[i]] = height_of_middle(flat[i]) < 0 ? -1 : 1;
        else
          left.push_back(flat[i]);
      }
      if (left.size() == flat.size()) {  // joined to nothing but each other
        for (const std::uint32_t piece : left) side[piece] = 1;
        left.clear();
      }
      flat = std::move(left);
    }
    return side;
  }

  [[nodiscard]] double height_of_middle(std::uint32_t piece) const {
    double sum = 0;
    for (const std::uint32_t c : pieces_[piece]) sum += height(c);
    return sum;
  }

  [[nodiscard]] bool on_lip(std::uint32_t corner) const {
    return corner < patch_.core && patch_.lip[corner] != 0 && fresh_[corner] == 0;
  }
  /// The side of a corner that is well off the plane; else 0.
  [[nodiscard]] int clear_side(std::uint32_t corner) const {
    if (on_cut_[corner] != 0 || on_lip(corner) || std::abs(height(corner)) <= patch_.flatness) return 0;
    return patch_.side[corner];
  }

  /// Faces that an earlier sweep left joined between vertices that it doubled otherwise: only where the tissue is
  /// clearly on both sides, or tets that lie flat on a lip would come off.
  void add_leftovers(std::vector<FaceKey>& open) const {
    if (options_.stroke == nullptr || options_.stroke->lips.empty()) return;
    const std::vector<CutFace> faces = faces_on_cut(true);
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
      const CutFace &one = faces[i], &other = faces[i + 1];
      if (one.key != other.key || clear_side(one.opposite) * clear_side(other.opposite) >= 0) continue;
      if (patch_.allowed[parent_[one.piece]] != 0 && patch_.allowed[parent_[other.piece]] != 0) open.push_back(one.key);
    }
    std::sort(open.begin(), open.end());
  }

  /// A piece with all corners on the cut has hardly any thickness: it must not come off on its own, so one of its faces
  /// stays joined, on the side that most of it lies.
  void keep_flat_pieces(std::vector<FaceKey>& open) const {
    std::vector<std::uint32_t> flat;
    std::vector<FaceKey> faces;  // of them
    const auto face_of = [&](std::uint32_t p, std::size_t f) {
      const auto& c = detail::face_corners[f];
      return detail::face_key(pieces_[p][c[0]], pieces_[p][c[1]], pieces_[p][c[2]]);
    };
    const auto on = [&](std::uint32_t corner) { return on_cut_[corner] != 0 || on_lip(corner); };
    for (std::uint32_t p = 0; p < pieces_.size(); ++p)
      if (std::all_of(pieces_[p].begin(), pieces_[p].end(), on)) flat.push_back(p);
    if (flat.empty() || open.empty()) return;
    for (const std::uint32_t p : flat)
      for (std::size_t f = 0; f < 4; ++f) faces.push_back(face_of(p, f));
    std::sort(faces.begin(), faces.end());
    std::vector<CutFace> tets;  // at those faces
    for (std::uint32_t p = 0; p < pieces_.size(); ++p)
      for (std::size_t f = 0; f < 4; ++f)
        if (const FaceKey key = face_of(p, f); std::binary_search(faces.begin(), faces.end(), key))
          tets.push_back({key, p, pieces_[p][f]});
    std::sort(tets.begin(), tets.end());
    for (const std::uint32_t p : flat) {
      const double middle = height_of_middle(p);
      const FaceKey* best = nullptr;
      double most = -std::numeric_limits<double>::infinity();
      bool joined = false;
      for (std::size_t f = 0; f < 4 && !joined; ++f) {
        const FaceKey key = face_of(p, f);
        auto at = std::lower_bound(tets.begin(), tets.end(), CutFace{key, 0, 0});
        for (; at != tets.end() && at->key == key; ++at) {
          if (at->piece == p) continue;
          const auto opened = std::lower_bound(open.begin(), open.end(), key);
          joined = joined || opened == open.end() || *opened != key;
          const double agrees = (middle < 0 ? -1 : 1) * height(at->opposite);
          if (agrees <= most) continue;
          most = agrees;
          best = &at->key;
        }
      }
      if (!joined && best != nullptr) open.erase(std::lower_bound(open.begin(), open.end(), *best));
    }
  }

  std::vector<FaceKey> faces_to_open() const {
    const std::vector<CutFace> faces = faces_on_cut(false);
    const std::vector<std::int8_t> side = sides_of_pieces(faces);
    std::vector<FaceKey> open;
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
      if (faces[i].key != faces[i + 1].key) continue;
      const std::uint32_t p = faces[i].piece, q = faces[i + 1].piece;
      if (side[p] == side[q] || patch_.allowed[parent_[p]] == 0 || patch_.allowed[parent_[q]] == 0) continue;
      open.push_back(faces[i].key);
    }
    add_leftovers(open);
    keep_flat_pieces(open);
    return open;
  }

  void measure(const std::vector<FaceKey>& open) {
    SplitReport& report = edit_.report;
    report.crossed = patch_.edges.size();
    double farthest = 0;
    const auto see = [&](std::uint32_t corner) {
      if (fresh_[corner] != 0) farthest = std::max(farthest, std::abs(height(corner)) + blade_.unevenness());
    };
    for (std::uint32_t v = 0; v < patch_.vertex.size(); ++v) {
      report.taken_as_on += plan_.meeting(v) == Meeting::taken ? 1 : 0;
      if (plan_.meeting(v) != Meeting::slid) continue;
      ++report.snapped;
      see(v);
    }
    for (std::uint32_t e = 0; e < patch_.edges.size(); ++e) {
      if (!plan_.bisected(e)) continue;
      ++report.bisected;
      see(static_cast<std::uint32_t>(patch_.vertex.size() + e));
    }
    for (const FaceKey& face : open)
      for (const std::uint32_t corner : face) see(corner);
    report.largest_distance = farthest;
    measure_pieces();
  }

  void measure_pieces() {
    SplitReport& report = edit_.report;
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      const std::uint32_t t = parent_[p];
      const auto& now = pieces_[p];
      const auto& old = patch_.corners[t];
      const auto slid = [&](std::uint32_t v) { return plan_.meeting(v) == Meeting::slid; };
      if (now == old && std::none_of(old.begin(), old.end(), slid)) continue;
      const std::array<Vec3, 4> x{plan_.rest(now[0]), plan_.rest(now[1]), plan_.rest(now[2]), plan_.rest(now[3])};
      const double angle = detail::smallest_dihedral(x[0], x[1], x[2], x[3]);
      report.angle_after = std::min(report.angle_after, angle);
      if (angle < options_.smallest_angle) ++report.too_sharp;
      report.volume_change += signed_volume(x[0], x[1], x[2], x[3]);
      if (p > 0 && parent_[p - 1] == t) continue;
      const auto& r = patch_.rest;
      report.angle_before =
          std::min(report.angle_before, detail::smallest_dihedral(r[old[0]], r[old[1]], r[old[2]], r[old[3]]));
      report.volume_change -= signed_volume(r[old[0]], r[old[1]], r[old[2]], r[old[3]]);
    }
  }

  /// The old vertices that a corner lies between, and how far along.
  [[nodiscard]] AddedVertex origin_of(std::uint32_t corner) const {
    const std::size_t n = patch_.vertex.size();
    if (corner >= n) {
      const detail::CrossedEdge& edge = patch_.edges[corner - n];
      return {plan_.rest(corner), patch_.vertex[edge.a], patch_.vertex[edge.b],
              plan_.share(static_cast<std::uint32_t>(corner - n))};
    }
    const VertexId v = patch_.vertex[corner];
    if (plan_.meeting(corner) != Meeting::slid) return {plan_.rest(corner), v, v, 0};
    const detail::CrossedEdge& edge = patch_.edges[plan_.slid_along(corner)];
    return edge.a == corner ? AddedVertex{plan_.rest(corner), v, patch_.vertex[edge.b], edge.share}
                            : AddedVertex{plan_.rest(corner), v, patch_.vertex[edge.a], 1 - edge.share};
  }

  void write_vertices() {
    const std::size_t n = patch_.vertex.size();
    number_.resize(fresh_.size() + origins_.size());
    const auto add = [&](std::size_t corner, std::uint32_t origin) {
      number_[corner] = VertexId(mesh_.vertex_count() + edit_.vertices.size());
      edit_.vertices.push_back(origin_of(origin));
    };
    for (std::uint32_t v = 0; v < n; ++v) {
      number_[v] = patch_.vertex[v];
      if (plan_.meeting(v) != Meeting::slid) continue;
      const AddedVertex slid = origin_of(v);
      edit_.moved.push_back({slid.from, slid.to, slid.weight, slid.position});
    }
    std::sort(edit_.moved.begin(), edit_.moved.end(),
              [](const MovedVertex& a, const MovedVertex& b) { return a.vertex < b.vertex; });
    for (std::uint32_t e = 0; e < patch_.edges.size(); ++e)
      if (plan_.bisected(e)) add(n + e, static_cast<std::uint32_t>(n + e));
    for (std::size_t k = 0; k < origins_.size(); ++k) add(fresh_.size() + k, origins_[k]);
  }

  void write_tets() {
    for (std::size_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {
      const std::uint32_t t = parent_[begin];
      while (end < pieces_.size() && parent_[end] == t) ++end;
      if (end == begin + 1 && pieces_[begin] == patch_.corners[t]) continue;
      edit_.removed.push_back(patch_.tet[t]);
      for (std::size_t p = begin; p < end; ++p) {
        Tet tet;
        for (std::size_t c = 0; c < 4; ++c) tet[c] = number_[pieces_[p][c]];
        edit_.tets.push_back({tet, patch_.tet[t]});
      }
    }
  }

  /// Vertices of the cut that are single still, and those that are not.
  void write_stroke() {
    Stroke& stroke = edit_.report.stroke;
    if (options_.stroke != nullptr) stroke = *options_.stroke;
    for (std::uint32_t c = 0; c < on_cut_.size(); ++c)
      if (on_cut_[c] != 0) stroke.front.push_back(number_[c]);
    for (std::size_t k = 0; k < origins_.size(); ++k) {
      stroke.lips.push_back(number_[origins_[k]]);
      stroke.lips.push_back(number_[on_cut_.size() + k]);
    }
    tidy(stroke);
  }

  const TetMesh& mesh_;
  const SplitPatch& patch_;
  const SplitPlan& plan_;
  const SweptPlane& blade_;
  const SplitOptions& options_;
  detail::Pieces pieces_;                     // after bisection
  std::vector<std::uint32_t> parent_;         // patch tet of each piece
  std::vector<std::uint8_t> fresh_, on_cut_;  // of corners
  std::vector<std::uint32_t> origins_;        // of copies
  std::vector<VertexId> number_;              // of corners and copies in the edit
  SplitEdit edit_;
};

std::string short_text(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

void write_notes(const SplitOptions& options, const SweptPlane& blade, SplitEdit& edit) {
  std::vector<std::string>& notes = edit.report.notes;
  if (edit.empty())
    notes.emplace_back("nothing is cut: the blade crosses no tetrahedron of the region");
  else if (edit.report.separated == 0)
    notes.emplace_back("no face was swept as a whole yet, so nothing opens");
  if (blade.unevenness() > options.flatness)
    notes.push_back("the sweep is bent: its corners lie up to " + short_text(blade.unevenness() * 1e3) +
                    " mm off the plane that was cut along");
  if (edit.report.too_sharp > 0)
    notes.push_back(std::to_string(edit.report.too_sharp) + " pieces have dihedral angles below " +
                    short_text(options.smallest_angle) + "°, the smallest " + short_text(edit.report.angle_after) +
                    "°");
}

SplitEdit split_along(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> current,
                      const SweptPlane& blade, const SplitOptions& options) {
  if (options.region != "*") regions_matching(mesh, options.region, "region");
  SplitPatch patch;
  if (!blade.empty()) patch = detail::gather_patch(mesh, around, current, blade, options);
  SplitEdit edit;
  if (patch.tet.empty()) {
    if (options.stroke != nullptr) edit.report.stroke = *options.stroke;
  } else {
    SplitPlan plan(patch);
    plan.search(options.smallest_angle);
    edit = Splitter(mesh, patch, plan, blade, options).run();
  }
  write_notes(options, blade, edit);
  return edit;
}

}  // namespace

SplitEdit split(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> current, const Sweep& sweep,
                const SplitOptions& options) {
  check(mesh, around, current, options);
  return split_along(mesh, around, current, SweptPlane(sweep, options.margin), options);
}

SplitEdit split(const TetMesh& mesh, const Blade& blade, const SplitOptions& options) {
  const VertexTets around = vertex_tets(mesh);
  check(mesh, around, mesh.positions, options);
  return split_along(mesh, around, mesh.positions, SweptPlane(blade, options.margin), options);
}

Stroke follow(const Stroke& stroke, const Remap& remap) {
  const std::size_t n = remap.vertex_to_new.size();
  const auto moved_on = [&](const std::vector<VertexId>& list) {
    std::vector<VertexId> now;
    for (const VertexId v : list) {
      const VertexId fresh = v.index() < n ? remap.vertex_to_new[v.index()] : remap.added_vertices.at(v.index() - n);
      if (fresh.valid()) now.push_back(fresh);
    }
    return now;
  };
  Stroke now{moved_on(stroke.front), moved_on(stroke.lips)};
  tidy(now);
  return now;
}

}  // namespace calot
