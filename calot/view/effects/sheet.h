// Inside this room only: a triangle surface that liquid runs on; it moves with the tissue, or stays.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "calot/view/snapshot.h"

namespace calot::detail {

constexpr std::uint32_t no_triangle = 0xffffffffU;

/// A point of a sheet.
struct Seat {
  std::uint32_t triangle = no_triangle;
  Vec3f weights = Vec3f::Constant(1.0F / 3);  ///< of its corners, ≥ 0, sum 1
};

/// Triangles, who is beside whom, and where things near them are. Triangles without area, with corners that aren't
/// finite or that name no vertex are there but not usable: nothing sits on them, and they are walls to what runs.
class Sheet {
 public:
  /// Another skin; what a seat means is lost.
  void take_skin(const TissueSkin& skin, const std::vector<Vec3f>& positions);
  void take_still(std::span<const Surface> surfaces);
  /// New places of the vertices; ignored where there are too few.
  void move(const std::vector<Vec3f>& positions);

  [[nodiscard]] std::size_t triangle_count() const { return triangles_.size(); }
  [[nodiscard]] const Triangle& triangle(std::uint32_t t) const { return triangles_[t]; }
  [[nodiscard]] const std::vector<Vec3f>& rests() const { return rest_; }  ///< of the vertices
  [[nodiscard]] bool usable(std::uint32_t t) const;
  [[nodiscard]] std::array<Vec3f, 3> corners(std::uint32_t t) const;
  [[nodiscard]] Vec3f normal(std::uint32_t t) const;  ///< unit; of a usable triangle
  [[nodiscard]] Vec3f position(const Seat& seat) const { return at(now_, seat); }
  [[nodiscard]] Vec3f rest(const Seat& seat) const { return at(rest_, seat); }
  [[nodiscard]] bool is_raw(std::uint32_t t) const;        ///< laid bare by a cut; not a tube's wall
  [[nodiscard]] Vec3f rest_normal(std::uint32_t t) const;  ///< unit, or zero
  [[nodiscard]] bool is_artery(std::uint32_t t) const;
  /// What lies beyond the edge opposite to corner k: a triangle (`no_triangle`: none) and its corner off that edge.
  struct Beyond {
    std::uint32_t triangle = no_triangle;
    int corner = 0;
  };
  [[nodiscard]] Beyond across(std::uint32_t t, int k) const;
  /// The triangle with these vertices, in any order.
  [[nodiscard]] std::uint32_t triangle_of(const std::array<std::uint32_t, 3>& vertices) const;

  struct Nearest {
    Seat seat;
    float distance = 0;
  };
  /// The nearest point of usable triangles within `reach` whose normals are within 90° of `facing` (zero: any).
  [[nodiscard]] std::optional<Nearest> nearest(const Vec3f& p, float reach, const Vec3f& facing = Vec3f::Zero());
  /// Where the way from a to b first enters the surface from outside; `both` sides count for a still one.
  [[nodiscard]] std::optional<Seat> hit(const Vec3f& a, const Vec3f& b, bool both);

 private:
  void index();
  void renew_grid();
  void build_grid();
  template <class Visit>
  void each_near(const Vec3f& low, const Vec3f& high, const Visit& visit);
  [[nodiscard]] Vec3f at(const std::vector<Vec3f>& places, const Seat& seat) const;

  std::vector<Vec3f> rest_, now_;
  std::vector<std::uint32_t> key_;          // of each vertex: those with the same key are one
  std::vector<std::uint8_t> raw_, artery_;  // of each vertex
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> start_, around_;  // triangles by key, compressed rows

  // Cells of a grid and the triangles whose boxes meet them, as of `then_`.
  std::vector<Vec3f> then_;
  std::vector<std::uint32_t> cell_start_, cell_items_;
  std::array<int, 3> cells_{};
  Vec3f corner_ = Vec3f::Zero();
  float cell_ = 1, slack_ = 0;
  bool moved_ = true, stale_ = true;
  std::vector<std::uint32_t> seen_;  // of each triangle: the last query that met it
  std::uint32_t query_ = 0;
};

/// What a walk along a sheet came to.
struct Walked {
  Seat seat;
  Vec3f direction = Vec3f::Zero();  ///< of the way, as it lies in the last triangle; unit or zero
  float left = 0;                   ///< of the way, not gone [m]
  bool blocked = false;             ///< by a border
};

/// Goes straight on over the edges, as if the sheet were unrolled, from a seat by `way` (its part along the sheet) [m].
Walked walk(const Sheet& sheet, const Seat& from, const Vec3f& way);

/// The nearest point of a triangle, as weights. Source: [Ericson2005], 5.1.5.
Vec3f nearest_on_triangle(const Vec3f& p, const std::array<Vec3f, 3>& corners);

}  // namespace calot::detail
