// A scene: tissue, instruments and what they do, as a plain value. What each key of a file means: docs/formats.md.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calot/scene/instrument_script.h"

namespace calot {

enum class BodyKind : std::uint8_t {
  still,  ///< "static": held in place wholly
  rigid,  ///< moves as one piece on what holds it
  deformable,
};
enum class CuttingMode : std::uint8_t { split, remove };

/// A box of tissue in cubes, six tets each; [m].
struct BlockShape {
  std::string region = "tissue";
  Vec3 centre = Vec3::Zero(), size = Vec3::Zero();
  double element_size = 0;      ///< edge of a cube, about
  std::array<bool, 6> fixed{};  ///< faces x−, x+, y−, y+, z−, z+ held in place
  std::string where;            ///< "FILE:LINE", for messages; empty for scenes made in memory
};

/// A solid tube of round cross-sections along a line; [m]. Two points make a cylinder.
struct TubeShape {
  std::vector<Vec3> points;
  std::vector<double> radii;                     ///< one a point
  std::vector<std::string> regions;              ///< one for each stretch between two points
  int rings = 2;                                 ///< of elements from the middle to the surface
  bool fixed_first = false, fixed_last = false;  ///< the end faces held in place
  std::string where;
};

/// What differs from the defaults for a region, or all of them ("*"); later entries win.
struct RegionSettings {
  std::string region = "*";
  std::optional<BodyKind> body;
  std::optional<bool> carried;            ///< see WorldOptions::carried; by default a patient's regions are
  std::map<std::string, double> figures;  ///< by key of the file, e.g. "young"; SI
  std::string where;
};

/// Something that doesn't move: a triangle surface from a file, or a flat square.
struct SceneSurface {
  std::string name;
  std::filesystem::path file;                         ///< empty: a square
  double scale = 1;                                   ///< metres per unit of the file
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();  ///< the square's middle [m]; unit, towards the tissue
  double size = 1;                                    ///< its edge [m]
  double friction = 0.3;
  std::string where;
};

struct SceneInstrument {
  std::string name;
  InstrumentKind kind = InstrumentKind::bowel_grasper;
  std::optional<Vec3> port;                  ///< [m]
  std::string port_name;                     ///< of the patient; where `port` is empty
  std::optional<double> friction, max_grip;  ///< against tissue; [N]; else the instrument's own
  double power = 30;                         ///< at the generator while energy is on [W]
  InstrumentScript script;
  std::filesystem::path poses;  ///< the file that the script's poses are from
  std::string where;
};

/// What a haptic device holds, and how it feels; see HapticOptions.
struct SceneHaptics {
  std::string instrument;                  ///< empty: the scene has none
  double stiffness = 1000, damping = 1.0;  ///< [N/m], [N·s/m]
  double max_force = 6.0;                  ///< [N]
};

/// Where a picture of the scene is taken from; what a run does doesn't depend on it.
struct SceneCamera {
  Vec3 eye = Vec3::Zero(), target = Vec3::Zero();  ///< [m], apart
  Vec3 up = Vec3::UnitZ();                         ///< unit, not along the view
};

struct Scene {
  std::string title;
  std::filesystem::path file;   ///< empty for scenes made in memory
  double time_step = 1.0 / 60;  ///< [s]
  std::uint64_t steps = 0;      ///< of a run without end given
  std::uint64_t seed = 1;
  Vec3 gravity = {0, 0, -9.81};                      ///< [m/s²]
  double rayleigh_mass = 0, rayleigh_stiffness = 0;  ///< [1/s], [s]
  // Where the tissue is from: one of these.
  std::filesystem::path patient, model;
  std::vector<BlockShape> blocks;
  std::vector<TubeShape> tubes;

  std::vector<RegionSettings> regions;
  std::vector<SceneSurface> surfaces;
  std::vector<SceneInstrument> instruments;
  double tissue_friction = 0.1;  ///< of tissue against tissue
  bool self_contact = true;
  int max_contacts = 64;
  SceneHaptics haptics;
  std::optional<SceneCamera> camera;  ///< empty: found from the tissue and the instruments
  CuttingMode cutting = CuttingMode::split;
  bool tearing = true, heat = true, fluids = true;
};

}  // namespace calot
