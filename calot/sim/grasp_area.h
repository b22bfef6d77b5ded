// What of the tissue's surface lies between two jaws.
#pragma once
#include <span>

#include "calot/sim/instrument.h"

namespace calot {

enum class JawSide : std::uint8_t { a, b };

/// The surface as a grasp and a clip see it; all of the same mesh.
struct TissueSurface {
  std::span<const std::array<VertexId, 3>> triangles;  ///< of the outer boundary, wound outwards
  std::span<const Vec3> positions;                     ///< of every vertex of the mesh [m]
};

/// One vertex's share of the surface that lies in one jaw's half of the mouth.
struct JawShare {
  VertexId vertex;
  JawSide side = JawSide::a;
  double area = 0;  ///< as the jaw sees it (projected along its closing direction), within their outline [m²]
  double near = 0;  ///< the part of `area` that is within reach of the face [m²]
  double gap = 0;   ///< of that surface from the face at its nearest place, < 0 where it is behind the face [m]
};

/// The surface between the jaws of an instrument.
struct MouthContents {
  std::vector<JawShare> shares;       ///< ascending by vertex, then side
  double extent_a = 0;                ///< largest angle that tissue reaches from the mouth's middle towards jaw a [rad]
  double extent_b = 0;                ///< the same towards jaw b; both are negative infinity where there is nothing
  std::vector<std::uint32_t> inside;  ///< triangles that reach into the mouth
  [[nodiscard]] bool empty() const { return shares.empty(); }
};

struct MouthSearch {
  Pose pose;               ///< of the instrument
  double opening = 0;      ///< [rad]
  double side_margin = 0;  ///< how far beyond the jaws' outline tissue is listed too, with no area [m]
  double face_margin = 0;  ///< how far behind the inner faces [m]
  double reach = 0;  ///< tissue within this distance of a face, or of where tissue reaches furthest, is near it [m]
};

/// Clips every triangle to the mouth: between the inner faces, within the jaws' outline, from where the faces begin to
/// the tips; then halves it midway between the two places where tissue reaches furthest. Cost: one box test for each
/// triangle, clipping for those that pass.
/// @param contents  overwritten; its memory is reused
void look_into_mouth(const InstrumentGeometry& geometry, const MouthSearch& search, const TissueSurface& surface,
                     MouthContents& contents);

}  // namespace calot
