// Inside this room only: what the models of several instruments have in common: tubes, the joint, and where grain runs.
#pragma once
#include <vector>

#include "calot/view/models/plain_mesh.h"

namespace calot::detail {

inline constexpr double model_mm = 1e-3;
inline constexpr double usual_crease = 0.61;  ///< 35°

using Parts = std::vector<ModelPart>;

Vec3 grain_round_z(const Vec3& point);  ///< turned on a lathe
Vec3 grain_along_z(const Vec3& point);

/// The mirror image in y = 0: jaw b from jaw a.
PlainMesh mirrored_in_y(PlainMesh mesh);
/// The same body turned by half a turn about z.
PlainMesh half_turned(PlainMesh mesh);
void append(PlainMesh& mesh, const PlainMesh& other);
/// How open to the light the vertices are that have been added since there were `first`.
void set_openness(PlainMesh& mesh, std::size_t first, const std::function<double(const Vec3&)>& openness);

/// The tube of the shaft's first piece: its radius and where its rounded end begins and ends, along z [m].
struct Tube {
  double start = 0, shoulder = 0, end = 0, radius = 0;
};
Tube tube_of(const InstrumentGeometry& geometry);

/// Black tube with a bevelled end at `end`.
ModelPart insulated_tube(const Tube& tube, double end);
/// Steel body with two cheeks that bear the jaws' pin, from `start` on; jaws swing in |x| < inner.
void add_clevis(Parts& parts, const Tube& tube, double start, double inner, double outer);

/// The root of jaw a: a disc about the pin between x = low and high.
void add_eye(PlainMesh& mesh, double radius, double low, double high);

/// The section of a jaw: its flat face in y = 0, `face` wide to each side; its back rounded, `depth` away.
Outline jaw_section(double half_width, double depth, double face, double tooth);
Ring ring_at(const Outline& section, const Vec3& origin);

// One for each kind.
Parts bowel_grasper_model(const InstrumentGeometry& geometry);
Parts curved_forceps_model(const InstrumentGeometry& geometry);
Parts clip_applier_model(const InstrumentGeometry& geometry);
Parts scissors_model(const InstrumentGeometry& geometry);
Parts hook_model(const InstrumentGeometry& geometry);
Parts suction_model(const InstrumentGeometry& geometry);
Parts fan_retractor_model(const InstrumentGeometry& geometry);

}  // namespace calot::detail
