// What a picture needs of the world at one moment: taken after a step, never changed once published.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "calot/mesh/surface.h"
#include "calot/sim/world.h"

namespace calot {

using Vec3f = Eigen::Vector3f;

/// What a tissue looks like; from the name of its region.
enum class TissueLook : std::uint8_t {
  soft,  ///< any other name
  liver,
  gallbladder,
  duct,
  artery,
  fat,
  bed,  ///< connective tissue between gallbladder and liver
  peritoneum,
};
TissueLook look_of(std::string_view region_name);

/// A corner of the tissue's skin: a vertex of the mesh as one tissue and one kind of face have it.
struct SkinVertex {
  std::uint32_t vertex = 0;  ///< of the mesh, until the next edit
  Vec3f rest =
      Vec3f::Zero();  ///< where it is at rest [m]; textures and masks live there, so that cuts leave them alone
  TissueLook look = TissueLook::soft;
  bool cut = false;  ///< of a face that an edit laid bare: it shows the tissue's inside
};

/// The skin; stays the same from one edit to the next.
struct TissueSkin {
  std::uint64_t version = 0;  ///< another one after each edit
  std::vector<SkinVertex> vertices;
  std::vector<Triangle> triangles;  ///< of skin vertices, counter-clockwise from outside
};

/// How the tissue at a skin vertex is, each 0 … 1.
struct SkinCondition {
  float coagulated = 0, charred = 0, blanched = 0, bruised = 0;
};

struct InstrumentSnapshot {
  InstrumentKind kind = InstrumentKind::bowel_grasper;
  std::string name;
  Pose pose;
  double opening = 0;  ///< [rad]
  bool energy = false;
  bool holds = false, holds_clip = false;
  double force = 0;    ///< of the tissue on it [N]
  double cautery = 0;  ///< power that reached tissue [W]
};

struct ClipSnapshot {
  Pose frame;  ///< as Clip::frame
  RigidShape shape;
  ClipState state = ClipState::closing;
};

struct FluidSnapshot {
  std::uint32_t id = 0;
  Fluid fluid = Fluid::blood;
  Vec3f position = Vec3f::Zero();           ///< [m]
  std::array<std::uint32_t, 3> triangle{};  ///< skin vertices of the triangle it is on
  double rate = 0;                          ///< now [m³/s]
  double shed = 0, pooled = 0;              ///< [m³]
};

/// Everything of one moment.
struct Snapshot {
  std::uint64_t step = 0;
  double time = 0, time_step = 0;  ///< [s]
  Vec3f gravity = Vec3f(0, 0, -9.81F);
  TissueSkin skin;
  std::vector<Vec3f> positions;           ///< of the skin's vertices [m]
  std::vector<SkinCondition> conditions;  ///< of the skin's vertices
  std::vector<InstrumentSnapshot> instruments;
  std::vector<ClipSnapshot> clips;
  std::vector<FluidSnapshot> fluids;
  std::vector<WorldEvent> events;           ///< of the steps since the snapshot before
  std::uint64_t first_event = 0;            ///< how many there were before those
  double blood_lost = 0, bile_spilled = 0;  ///< [m³]
};

}  // namespace calot
