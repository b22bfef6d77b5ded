// A place where tissue touches, or is about to touch, something within this step.
#pragma once
#include <array>
#include <cstdint>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// A point on the tissue's surface, by the corners of its triangle.
struct SurfacePoint {
  std::array<VertexId, 3> vertices;
  Vec3 weights = Vec3::Zero();  ///< ≥ 0, sum 1
  TetId tet;                    ///< behind the triangle
};

enum class ContactPartner : std::uint8_t {
  shape,   ///< a moving rigid shape (instrument part)
  tissue,  ///< the tissue's own surface elsewhere
  still,   ///< a triangle surface that doesn't move (a static organ that isn't meshed, the abdominal wall)
};

struct TissueContact {
  SurfacePoint point;
  ContactPartner partner = ContactPartner::shape;
  std::uint32_t shape = 0;             ///< number of the moving shape, or of the still surface
  SurfacePoint other;                  ///< on the tissue, for ContactPartner::tissue
  Vec3 place = Vec3::Zero();           ///< the partner's touching point at the start of the step [m]
  Vec3 normal = Vec3::UnitZ();         ///< unit, from the partner towards the tissue
  double gap = 0;                      ///< distance at the start of the step, < 0 where they overlap [m]
  Vec3 partner_motion = Vec3::Zero();  ///< how the partner's touching point moves in this step [m]
  double friction = 0;                 ///< Coulomb's coefficient
  std::uint64_t key = 0;               ///< names the pair of features from step to step, for warm starts
};

/// Rows: the normal and two tangents, right-handed and orthonormal; a function of the normal alone.
Eigen::Matrix3d contact_frame(const Vec3& normal);

}  // namespace calot
