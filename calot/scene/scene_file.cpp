#include "calot/scene/scene_file.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/mesh/mesh_file.h"
#include "calot/scene/pose_file.h"
#include "calot/scene/region_figures.h"
#include "calot/scene/scene_values.h"

namespace calot {
namespace {

namespace fs = std::filesystem;
using detail::TomlFile;

const std::vector<std::string> faces{"x-", "x+", "y-", "y+", "z-", "z+"};
const std::vector<std::string> bodies{"static", "rigid", "deformable"};
const std::vector<std::string> cutting_modes{"split", "remove"};

std::vector<std::string> kind_words() {
  std::vector<std::string> words;
  for (int k = 0; k <= static_cast<int>(InstrumentKind::fan_retractor); ++k)
    words.emplace_back(name_of(static_cast<InstrumentKind>(k)));
  return words;
}

class SceneReader {
 public:
  explicit SceneReader(const fs::path& path) : values_(path), toml_(values_.toml()) {}

  Scene read() {
    const toml::value& root = toml_.root();
    toml_.allow_only(root, {"title",   "length_unit", "time_step", "seconds",       "steps",
                            "seed",    "gravity",     "patient",   "rayleigh_mass", "rayleigh_stiffness",
                            "model",   "block",       "tube",      "region",        "floor",
                            "surface", "instrument",  "contact",   "haptics",       "cutting",
                            "tearing", "heat",        "fluids",    "camera"});
    scene_.file = toml_.path();
    read_general(root);
    read_source(root);
    for (const toml::value& table : toml_.tables("region")) read_region(table);
    for (const toml::value& table : toml_.tables("floor")) read_floor(table);
    for (const toml::value& table : toml_.tables("surface")) read_surface_file(table);
    for (const toml::value& table : toml_.tables("instrument")) read_instrument(table);
    if (const toml::value* table = toml_.section("contact")) read_contact(*table);
    if (const toml::value* table = toml_.section("haptics")) read_haptics(*table);
    if (const toml::value* table = toml_.section("camera")) read_camera(*table);
    read_steps(root);
    return std::move(scene_);
  }

 private:
  void read_general(const toml::value& root) {
    values_.text(root, "title", scene_.title);
    values_.number(root, "time_step", 1e-4, 0.1, "s", scene_.time_step);
    values_.number(root, "rayleigh_mass", 0, 1e3, "1/s", scene_.rayleigh_mass);
    values_.number(root, "rayleigh_stiffness", 0, 10, "s", scene_.rayleigh_stiffness);
    std::int64_t seed = static_cast<std::int64_t>(scene_.seed);
    values_.whole(root, "seed", 0, INT64_MAX, seed);
    scene_.seed = static_cast<std::uint64_t>(seed);
    if (const toml::value* gravity = TomlFile::find(root, "gravity")) {
      scene_.gravity = toml_.point(*gravity, "gravity");
      if (!(scene_.gravity.stableNorm() <= 100))
        toml_.fail(*gravity, "gravity is above 100 m/s2", "give e.g. [0.0, 0.0, -9.81], in m/s2");
    }
    std::size_t mode = 0;
    values_.word(root, "cutting", cutting_modes, mode);
    scene_.cutting = static_cast<CuttingMode>(mode);
    values_.yes_or_no(root, "tearing", scene_.tearing);
    values_.yes_or_no(root, "heat", scene_.heat);
    values_.yes_or_no(root, "fluids", scene_.fluids);
  }

  /// After the instruments: without steps or seconds, a run lasts as long as their scripts.
  void read_steps(const toml::value& root) {
    const toml::value* seconds = TomlFile::find(root, "seconds");
    const toml::value* steps = TomlFile::find(root, "steps");
    if (seconds != nullptr && steps != nullptr)
      toml_.fail(*seconds, "seconds and steps both say how long the run is", "leave one out");
    std::int64_t count = 0;
    values_.whole(root, "steps", 1, 100'000'000, count);
    double end = 0;
    for (const SceneInstrument& instrument : scene_.instruments) end = std::max(end, instrument.script.end());
    if (seconds != nullptr) end = toml_.number_in(*seconds, "seconds", 0, 1e5, "s");
    scene_.steps = steps != nullptr ? static_cast<std::uint64_t>(count)
                                    : static_cast<std::uint64_t>(std::ceil(end / scene_.time_step - 1e-9));
  }

  void read_source(const toml::value& root) {
    values_.file(root, "patient", scene_.patient);
    values_.file(root, "model", scene_.model);
    for (const toml::value& table : toml_.tables("block")) read_block(table);
    for (const toml::value& table : toml_.tables("tube")) read_tube(table);
    const bool shapes = !scene_.blocks.empty() || !scene_.tubes.empty();
    const int sources = (scene_.patient.empty() ? 0 : 1) + (scene_.model.empty() ? 0 : 1) + (shapes ? 1 : 0);
    if (sources == 0)
      throw InputError(toml_.path().string(), "the scene has no tissue",
                       "add a patient, a model, a [[block]] or a [[tube]]");
    if (sources > 1)
      throw InputError(toml_.path().string(), "the tissue comes from more than one place",
                       "keep one of patient, model, and blocks and tubes");
  }

  void read_block(const toml::value& table) {
    toml_.allow_only(table, {"region", "centre", "size", "element_size", "fixed"});
    BlockShape block;
    block.where = toml_.at(table);
    values_.text(table, "region", block.region);
    values_.place(table, "centre", block.centre);
    const toml::value& size = toml_.need(table, "size", "[60.0, 20.0, 20.0]");
    block.size = values_.place(size, "size");
    if (!(block.size.minCoeff() >= 1e-5)) toml_.fail(size, "the block has no size", "give three lengths above 0");
    block.element_size = values_.length(toml_.need(table, "element_size", "5.0"), "element_size", 1e-5, 10);
    if (const toml::value* fixed = TomlFile::find(table, "fixed"))
      for (const toml::value& face : toml_.array(*fixed, "fixed")) {
        const std::string& name = toml_.text(face, "a face of fixed");
        const auto found = std::find(faces.begin(), faces.end(), name);
        if (found == faces.end())
          toml_.fail(face, "a block has no face \"" + detail::brief(name) + "\"", "use x-, x+, y-, y+, z- or z+");
        block.fixed[static_cast<std::size_t>(found - faces.begin())] = true;
      }
    scene_.blocks.push_back(std::move(block));
  }

  void read_tube(const toml::value& table) {
    toml_.allow_only(table, {"region", "regions", "points", "radius", "radii", "rings", "fixed"});
    TubeShape tube;
    tube.where = toml_.at(table);
    const toml::value& points = toml_.need(table, "points", "[[0.0, 0.0, 0.0], [30.0, 0.0, 0.0]]");
    for (const toml::value& point : toml_.array(points, "points"))
      tube.points.push_back(values_.place(point, "a point of points"));
    if (tube.points.size() < 2) toml_.fail(points, "a tube needs two points or more", "add the other end");
    for (std::size_t i = 0; i + 1 < tube.points.size(); ++i)
      if ((tube.points[i + 1] - tube.points[i]).norm() < 1e-5)
        toml_.fail(points, "two points of the tube lie at the same place", "leave one out");
    read_radii(table, tube);
    read_stretches(table, tube);
    std::int64_t rings = tube.rings;
    values_.whole(table, "rings", 1, 50, rings);
    tube.rings = static_cast<int>(rings);
    if (const toml::value* fixed = TomlFile::find(table, "fixed"))
      for (const toml::value& end : toml_.array(*fixed, "fixed")) {
        const std::string& name = toml_.text(end, "an end of fixed");
        if (name != "first" && name != "last")
          toml_.fail(end, "a tube has no end \"" + detail::brief(name) + "\"", "use \"first\" or \"last\"");
        (name == "first" ? tube.fixed_first : tube.fixed_last) = true;
      }
    scene_.tubes.push_back(std::move(tube));
  }

  void read_radii(const toml::value& table, TubeShape& tube) {
    const toml::value* radii = TomlFile::find(table, "radii");
    const toml::value* radius = TomlFile::find(table, "radius");
    if ((radii != nullptr) == (radius != nullptr))
      toml_.fail(table, "a tube needs radius or radii", "write e.g. radius = 2.0, or radii with one for each point");
    if (radius != nullptr) tube.radii.assign(tube.points.size(), values_.length(*radius, "radius", 1e-5, 1));
    if (radii == nullptr) return;
    for (const toml::value& entry : toml_.array(*radii, "radii"))
      tube.radii.push_back(values_.length(entry, "a radius of radii", 1e-5, 1));
    if (tube.radii.size() != tube.points.size())
      toml_.fail(*radii,
                 std::to_string(tube.radii.size()) + " radii for " + std::to_string(tube.points.size()) + " points",
                 "give one for each point");
  }

  void read_stretches(const toml::value& table, TubeShape& tube) {
    const toml::value* regions = TomlFile::find(table, "regions");
    std::string region = "tissue";
    if (regions != nullptr && TomlFile::find(table, "region") != nullptr)
      toml_.fail(*regions, "region and regions both name the tube's tissue", "leave one out");
    values_.text(table, "region", region);
    tube.regions.assign(tube.points.size() - 1, region);
    if (regions == nullptr) return;
    tube.regions.clear();
    for (const toml::value& entry : toml_.array(*regions, "regions"))
      tube.regions.push_back(toml_.text(entry, "a region of regions"));
    if (tube.regions.size() + 1 != tube.points.size())
      toml_.fail(*regions,
                 std::to_string(tube.regions.size()) + " regions for " + std::to_string(tube.points.size() - 1) +
                     " stretches between points",
                 "give one for each");
  }

  void read_region(const toml::value& table) {
    std::vector<std::string> known{"region", "body", "carried"};
    for (const detail::RegionFigure& figure : detail::region_figures()) known.emplace_back(figure.key);
    toml_.allow_only(table, known);
    RegionSettings settings;
    settings.where = toml_.at(table);
    settings.region = toml_.text(toml_.need(table, "region", "\"liver\""), "region");
    if (TomlFile::find(table, "body") != nullptr) {
      std::size_t body = 0;
      values_.word(table, "body", bodies, body);
      settings.body = static_cast<BodyKind>(body);
    }
    if (TomlFile::find(table, "carried") != nullptr) {
      bool carried = false;
      values_.yes_or_no(table, "carried", carried);
      settings.carried = carried;
    }
    for (const detail::RegionFigure& figure : detail::region_figures()) {
      const toml::value* value = TomlFile::find(table, figure.key);
      if (value == nullptr) continue;
      settings.figures[figure.key] = figure.is_length
                                         ? values_.length(*value, figure.key, figure.low, figure.high)
                                         : toml_.number_in(*value, figure.key, figure.low, figure.high, figure.unit);
    }
    scene_.regions.push_back(std::move(settings));
  }

  void read_floor(const toml::value& table) {
    toml_.allow_only(table, {"name", "point", "normal", "size", "friction"});
    SceneSurface still;
    still.where = toml_.at(table);
    still.name = "floor";
    values_.text(table, "name", still.name);
    values_.place(table, "point", still.point);
    values_.direction(table, "normal", still.normal);
    values_.length(table, "size", 1e-3, 10, still.size);
    values_.number(table, "friction", 0, 10, "", still.friction);
    scene_.surfaces.push_back(std::move(still));
  }

  void read_surface_file(const toml::value& table) {
    toml_.allow_only(table, {"name", "file", "length_unit", "friction"});
    SceneSurface still;
    still.where = toml_.at(table);
    (void)toml_.need(table, "file", "\"wall.stl\"");
    values_.file(table, "file", still.file);
    still.name = still.file.stem().string();
    values_.text(table, "name", still.name);
    still.scale = values_.metres();
    if (const toml::value* unit = TomlFile::find(table, "length_unit"))
      still.scale = metres_per(toml_.text(*unit, "length_unit"), toml_.at(*unit));
    values_.number(table, "friction", 0, 10, "", still.friction);
    scene_.surfaces.push_back(std::move(still));
  }

  void read_instrument(const toml::value& table) {
    toml_.allow_only(table,
                     {"name", "kind", "port", "direction", "friction", "max_grip", "power", "keyframes", "poses"});
    SceneInstrument tool;
    tool.where = toml_.at(table);
    tool.name = toml_.text(toml_.need(table, "name", "\"grasper\""), "name");
    for (const SceneInstrument& other : scene_.instruments)
      if (other.name == tool.name)
        toml_.fail(table, "there are two instruments \"" + detail::brief(tool.name) + "\"", "give each its own name");
    (void)toml_.need(table, "kind", "\"bowel grasper\"");
    std::size_t kind = 0;
    values_.word(table, "kind", kind_words(), kind);
    tool.kind = static_cast<InstrumentKind>(kind);
    read_port(table, tool);
    tool.friction = optional_number(table, "friction", 0, 10, "");
    tool.max_grip = optional_number(table, "max_grip", 0, 100, "N");
    values_.number(table, "power", 0, 200, "W", tool.power);
    read_script(table, tool);
    scene_.instruments.push_back(std::move(tool));
  }

  [[nodiscard]] std::optional<double> optional_number(const toml::value& table, const char* key, double low,
                                                      double high, const char* unit) const {
    const toml::value* value = TomlFile::find(table, key);
    if (value == nullptr) return {};
    return toml_.number_in(*value, key, low, high, unit);
  }

  void read_port(const toml::value& table, SceneInstrument& tool) const {
    const toml::value* port = TomlFile::find(table, "port");
    if (port == nullptr) return;
    if (TomlFile::find(table, "direction") != nullptr)
      toml_.fail(*port, "port and direction both say where the instrument points", "leave one out");
    if (port->is_array()) {
      tool.port = values_.place(*port, "port");
      return;
    }
    values_.text(table, "port", tool.port_name);
    if (scene_.patient.empty()) toml_.fail(*port, "a port has a name in a patient only", "give its place as [x, y, z]");
  }

  void read_script(const toml::value& table, SceneInstrument& tool) {
    const toml::value* keyframes = TomlFile::find(table, "keyframes");
    const toml::value* poses = TomlFile::find(table, "poses");
    if ((keyframes != nullptr) == (poses != nullptr))
      toml_.fail(table, "an instrument needs keyframes or poses", "write keyframes = [{ time = 0, tip = [0, 0, 0] }]");
    if (poses != nullptr) {
      for (const char* key : {"port", "direction"})
        if (const toml::value* value = TomlFile::find(table, key))
          toml_.fail(*value, "recorded poses say where the instrument points", std::string("leave ") + key + " out");
      values_.file(table, "poses", tool.poses);
      std::error_code code;
      if (!fs::is_regular_file(tool.poses, code))
        toml_.fail(*poses, "no file " + detail::brief(tool.poses.string()), "name it relative to the scene");
      tool.script = read_poses(tool.poses, values_.metres());
      return;
    }
    InstrumentKey key;
    values_.direction(table, "direction", key.direction);
    for (const toml::value& entry : toml_.array(*keyframes, "keyframes")) {
      if (!entry.is_table()) toml_.fail(entry, "a keyframe must be a table", "write { time = 0, tip = [0, 0, 0] }");
      key = read_key(entry, key, tool);
      tool.script.keys.push_back(key);
    }
    if (tool.script.keys.empty()) toml_.fail(*keyframes, "there are no keyframes", "write one at least");
  }

  /// What a keyframe leaves out stays as it was.
  InstrumentKey read_key(const toml::value& entry, InstrumentKey key, const SceneInstrument& tool) {
    toml_.allow_only(entry, {"time", "tip", "direction", "roll", "opening", "grip", "energy", "fire"});
    const bool first = tool.script.keys.empty();
    const double before = key.time;
    const toml::value& time = toml_.need(entry, "time", "0.5");
    key.time = toml_.number_in(time, "time", 0, 1e5, "s");
    if (!first && key.time <= before) toml_.fail(time, "the time doesn't grow", "order keyframes by time");
    if (first) (void)toml_.need(entry, "tip", "[0.0, 0.0, 50.0]");
    values_.place(entry, "tip", key.tip);
    if (tool.port && (key.tip - *tool.port).norm() < 5e-3)
      toml_.fail(entry, "the tip lies in its port", "keep it 5 mm away from there at least");
    if (const toml::value* direction = TomlFile::find(entry, "direction");
        direction != nullptr && (tool.port || !tool.port_name.empty()))
      toml_.fail(*direction, "with a port the direction follows from there", "leave it out");
    values_.direction(entry, "direction", key.direction);
    values_.angle(entry, "roll", -3600, 3600, key.roll);
    values_.angle(entry, "opening", 0, 180, key.opening);
    values_.number(entry, "grip", 0, 100, "N", key.grip);
    values_.yes_or_no(entry, "energy", key.energy);
    values_.yes_or_no(entry, "fire", key.fire);
    return key;
  }

  void read_contact(const toml::value& table) {
    toml_.allow_only(table, {"tissue_friction", "self_contact", "max_contacts"});
    values_.number(table, "tissue_friction", 0, 10, "", scene_.tissue_friction);
    values_.yes_or_no(table, "self_contact", scene_.self_contact);
    std::int64_t most = scene_.max_contacts;
    values_.whole(table, "max_contacts", 1, 1000, most);
    scene_.max_contacts = static_cast<int>(most);
  }

  void read_haptics(const toml::value& table) {
    toml_.allow_only(table, {"instrument", "stiffness", "damping", "max_force"});
    SceneHaptics& haptics = scene_.haptics;
    const toml::value& name = toml_.need(table, "instrument", "\"grasper\"");
    haptics.instrument = toml_.text(name, "instrument");
    std::vector<std::string> names;
    for (const SceneInstrument& tool : scene_.instruments) names.push_back(tool.name);
    if (std::find(names.begin(), names.end(), haptics.instrument) == names.end())
      toml_.fail(name, "there is no instrument \"" + detail::brief(haptics.instrument) + "\"",
                 names.empty() ? "add an [[instrument]]" : detail::suggestion(haptics.instrument, names));
    values_.number(table, "stiffness", 1, 1e5, "N/m", haptics.stiffness);
    values_.number(table, "damping", 0, 100, "N s/m", haptics.damping);
    values_.number(table, "max_force", 0, 100, "N", haptics.max_force);
  }

  void read_camera(const toml::value& table) {
    toml_.allow_only(table, {"eye", "target", "up"});
    SceneCamera camera;
    (void)toml_.need(table, "eye", "[0.0, -100.0, 60.0]");
    (void)toml_.need(table, "target", "[0.0, 0.0, 0.0]");
    values_.place(table, "eye", camera.eye);
    values_.place(table, "target", camera.target);
    values_.direction(table, "up", camera.up);
    const Vec3 gaze = camera.target - camera.eye;
    if (!(gaze.norm() >= 5e-3)) toml_.fail(table, "the camera is where it looks", "put eye 5 mm away from target");
    if (!(camera.up.cross(gaze).norm() > 1e-3 * gaze.norm()))
      toml_.fail(table, "the camera's up lies along its view", "give another direction, e.g. up = [0.0, 1.0, 0.0]");
    scene_.camera = camera;
  }

  detail::SceneValues values_;
  const TomlFile& toml_;
  Scene scene_;
};

}  // namespace

Scene read_scene(const fs::path& path) {
  return SceneReader(path).read();
}

}  // namespace calot
