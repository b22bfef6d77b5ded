// Inside this room only: which vertices go onto the blade and in what order edges are bisected, for the best angles.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "calot/cut/split_patch.h"

namespace calot::detail {

/// How a vertex of the patch meets the blade.
enum class Meeting : std::uint8_t {
  off,    ///< beside it
  given,  ///< in its plane, or on the cut from earlier sweeps
  taken,  ///< counts as on it where it is
  slid,   ///< slides onto it along a crossed edge
};

/// A tet's corner lists: of the pieces it becomes. Vertex v of the patch is v, the point on edge e is vertices + e.
using Pieces = std::vector<std::array<std::uint32_t, 4>>;

/// The choices, and the search for good ones. Every tet's pieces follow from the choices at its own corners and edges
/// alone, so a choice is tried by looking at the tets around it. What is to be made small is the sum over tets of a
/// price that grows steeply as the smallest dihedral falls; each accepted choice lowers it, so the search ends.
class SplitPlan {
 public:
  explicit SplitPlan(const SplitPatch& patch);
  /// @param wanted  smallest dihedral [°]; below it single choices are not the end of it
  void search(double wanted);

  [[nodiscard]] Meeting meeting(std::uint32_t v) const { return meeting_[v]; }
  [[nodiscard]] std::uint32_t slid_along(std::uint32_t v) const { return along_[v]; }  ///< edge, where slid
  [[nodiscard]] bool bisected(std::uint32_t edge) const {
    return !on(patch_.edges[edge].a) && !on(patch_.edges[edge].b);
  }
  [[nodiscard]] double share(std::uint32_t edge) const { return share_[edge]; }
  /// Rest or current position of a piece's corner.
  [[nodiscard]] const Vec3& rest(std::uint32_t corner) const {
    return corner < patch_.vertex.size() ? rest_[corner] : edge_rest_[corner - patch_.vertex.size()];
  }
  [[nodiscard]] const Vec3& now(std::uint32_t corner) const {
    return corner < patch_.vertex.size() ? now_[corner] : edge_now_[corner - patch_.vertex.size()];
  }
  void pieces_of(std::uint32_t tet, Pieces& pieces) const;
  [[nodiscard]] double smallest_angle(std::uint32_t tet) const;  ///< of its pieces [°]

 private:
  struct Choice {
    Meeting meeting = Meeting::off;
    std::uint32_t along = SplitPatch::none;
  };
  [[nodiscard]] bool on(std::uint32_t v) const { return meeting_[v] != Meeting::off; }
  void find_given();
  void find_outlines();
  void list_choices(std::uint32_t v, bool generous);
  [[nodiscard]] bool keeps_outline(std::uint32_t v, const Vec3& place, double slack) const;
  void set(std::uint32_t v, const Choice& choice);
  void set_share(std::uint32_t edge, double share);
  [[nodiscard]] double price(std::uint32_t tet) const;
  template <class Tets>
  [[nodiscard]] double price_of(const Tets& tets) const;
  bool choose(std::uint32_t v);
  bool reorder(std::uint32_t edge);
  bool shift(std::uint32_t edge);
  bool mend(std::uint32_t tet);
  bool rearrange(std::uint32_t tet);
  [[nodiscard]] std::vector<std::uint32_t> tets_about(std::uint32_t tet) const;
  void restore(const SplitPlan& before);
  void settle(const std::vector<std::uint32_t>& tets);

  const SplitPatch& patch_;
  std::vector<Meeting> meeting_;
  std::vector<std::uint32_t> along_;
  std::vector<Vec3> rest_, now_;                                    // of vertices, as chosen
  std::vector<double> share_;                                       // of edges
  std::vector<Vec3> edge_rest_, edge_now_;                          // points on edges
  std::vector<double> priority_;                                    // of edges: the highest is bisected first
  double highest_ = 0, lowest_ = 0;                                 // priorities so far
  std::vector<std::vector<Choice>> choices_;                        // of vertices
  std::vector<std::vector<std::array<std::uint32_t, 2>>> outline_;  // other corners of the boundary faces at a vertex
  mutable Pieces scratch_;
};

}  // namespace calot::detail
