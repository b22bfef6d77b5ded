// Where tissue touches, or may touch within this step, instruments, still surfaces and itself.
#pragma once
#include "calot/contact/contact_surface.h"
#include "calot/contact/rigid_shape.h"

namespace calot {

struct ContactOptions {
  double margin = 1e-3;   ///< contacts whose gap is expected to be below this at the step's end are reported [m]
  double spacing = 2e-3;  ///< between the contacts of one pair of bodies; grows while there are too many [m]
  std::size_t max_contacts = 40;
  double tissue_friction = 0.1;  ///< Coulomb's coefficient of tissue on tissue
  double deepest_overlap =
      2e-3;  ///< of tissue with tissue or a still surface; what is deeper is taken for something else [m]
  bool self_contact = true;
};

/// What tissue may touch.
struct ContactPartners {
  std::span<const MovingShape> shapes;
  std::span<const StillSurface> still;
};

/// The contacts of this step, reduced to a set that is spread over each patch: at most `max_contacts`, deepest first
/// (expected gap at the step's end), ties by key. Each is a linear condition for the step:
///   gap + normal · (tissue's motion at `point` − partner's motion) ≥ 0,
/// with `partner_motion` or, for tissue, the motion at `other`.
/// Shapes: along the screw motion each piece is followed until it first comes near a triangle; the condition is set up
/// there, with the normal there, for the material points that touch there, and `gap` is their distance along it at the
/// step's start. A piece whose core is inside tissue gets the way out through the nearest surface as its normal.
/// Tissue with tissue: faces that look at each other and weren't back to back in the rest shape. Faces freshly
/// separated have gap 0 and the normal between them.
/// Refits the surface. One thread; deterministic.
/// @param positions  n [m]
/// @param motion     n, where the vertices are thought to move in this step; or empty [m]
/// Throws InputError where sizes don't fit, a shape is missing, or a radius isn't positive.
std::vector<TissueContact> detect(ContactSurface& surface, std::span<const Vec3> positions,
                                  std::span<const Vec3> motion, const ContactPartners& partners,
                                  const ContactOptions& options);

}  // namespace calot
