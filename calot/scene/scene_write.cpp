#include <array>
#include <cmath>
#include <ostream>

#include "calot/base/toml_file.h"
#include "calot/scene/scene_file.h"

namespace calot {
namespace {

using detail::toml_real;
using detail::toml_text;

std::string list(const Vec3& v) {
  return "[" + toml_real(v[0]) + ", " + toml_real(v[1]) + ", " + toml_real(v[2]) + "]";
}

template <class Values, class Text>
std::string list(const Values& values, const Text& text) {
  std::string out = "[";
  for (const auto& value : values) out += (out.size() > 1 ? ", " : "") + std::string(text(value));
  return out + "]";
}

const char* word(bool value) {
  return value ? "true" : "false";
}

/// Degrees that read back as the same angle where a double can do that.
std::string degrees(double radians) {
  double value = radians * 180 / M_PI;
  for (const double other : {std::nextafter(value, -1e9), std::nextafter(value, 1e9)})
    if (M_PI / 180 * value != radians && M_PI / 180 * other == radians) value = other;
  return toml_real(value);
}

void write_general(std::ostream& out, const Scene& s) {
  if (!s.title.empty()) out << "title = " << toml_text(s.title) << '\n';
  out << "time_step = " << toml_real(s.time_step) << "  # s\n";
  if (s.steps > 0) out << "steps = " << s.steps << '\n';
  out << "seed = " << s.seed << "\ngravity = " << list(s.gravity) << "  # m/s2\n"
      << "rayleigh_mass = " << toml_real(s.rayleigh_mass) << "  # 1/s\n"
      << "rayleigh_stiffness = " << toml_real(s.rayleigh_stiffness) << "  # s\n"
      << "cutting = " << (s.cutting == CuttingMode::split ? "\"split\"" : "\"remove\"")
      << "\ntearing = " << word(s.tearing) << "\nheat = " << word(s.heat) << "\nfluids = " << word(s.fluids) << '\n';
  if (!s.patient.empty()) out << "patient = " << toml_text(s.patient.string()) << '\n';
  if (!s.model.empty()) out << "model = " << toml_text(s.model.string()) << '\n';
  out << "\n[contact]\ntissue_friction = " << toml_real(s.tissue_friction)
      << "\nself_contact = " << word(s.self_contact) << "\nmax_contacts = " << s.max_contacts << '\n';
}

void write_shapes(std::ostream& out, const Scene& s) {
  static constexpr std::array<const char*, 6> faces{"\"x-\"", "\"x+\"", "\"y-\"", "\"y+\"", "\"z-\"", "\"z+\""};
  for (const BlockShape& block : s.blocks) {
    std::vector<std::string> fixed;
    for (std::size_t f = 0; f < faces.size(); ++f)
      if (block.fixed[f]) fixed.emplace_back(faces[f]);
    out << "\n[[block]]\nregion = " << toml_text(block.region) << "\ncentre = " << list(block.centre)
        << "\nsize = " << list(block.size) << "\nelement_size = " << toml_real(block.element_size)
        << "\nfixed = " << list(fixed, [](const std::string& face) { return face; }) << '\n';
  }
  for (const TubeShape& tube : s.tubes) {
    std::vector<std::string> fixed;
    if (tube.fixed_first) fixed.emplace_back("\"first\"");
    if (tube.fixed_last) fixed.emplace_back("\"last\"");
    out << "\n[[tube]]\nregions = " << list(tube.regions, toml_text)
        << "\npoints = " << list(tube.points, [](const Vec3& p) { return list(p); })
        << "\nradii = " << list(tube.radii, toml_real) << "\nrings = " << tube.rings
        << "\nfixed = " << list(fixed, [](const std::string& end) { return end; }) << '\n';
  }
}

void write_regions(std::ostream& out, const Scene& s) {
  static constexpr std::array<const char*, 3> bodies{"static", "rigid", "deformable"};
  for (const RegionSettings& region : s.regions) {
    out << "\n[[region]]\nregion = " << toml_text(region.region) << '\n';
    if (region.body) out << "body = \"" << bodies[static_cast<std::size_t>(*region.body)] << "\"\n";
    if (region.carried) out << "carried = " << word(*region.carried) << '\n';
    for (const auto& [key, value] : region.figures) out << key << " = " << toml_real(value) << '\n';
  }
  for (const SceneSurface& still : s.surfaces) {
    if (still.file.empty())
      out << "\n[[floor]]\nname = " << toml_text(still.name) << "\npoint = " << list(still.point)
          << "\nnormal = " << list(still.normal) << "\nsize = " << toml_real(still.size);
    else
      out << "\n[[surface]]\nname = " << toml_text(still.name) << "\nfile = " << toml_text(still.file.string())
          << "\nlength_unit = "
          << (still.scale == 1      ? "\"m\""
              : still.scale == 0.01 ? "\"cm\""
                                    : "\"mm\"");
    out << "\nfriction = " << toml_real(still.friction) << '\n';
  }
}

void write_keys(std::ostream& out, const SceneInstrument& tool) {
  const bool has_port = tool.port || !tool.port_name.empty();
  out << "keyframes = [\n";
  for (const InstrumentKey& key : tool.script.keys) {
    out << "  { time = " << toml_real(key.time) << ", tip = " << list(key.tip);
    if (!has_port) out << ", direction = " << list(key.direction);
    out << ", roll = " << degrees(key.roll) << ", opening = " << degrees(key.opening)
        << ", grip = " << toml_real(key.grip) << ", energy = " << word(key.energy) << ", fire = " << word(key.fire)
        << " },\n";
  }
  out << "]\n";
}

void write_instrument(std::ostream& out, const SceneInstrument& tool) {
  out << "\n[[instrument]]\nname = " << toml_text(tool.name)
      << "\nkind = " << toml_text(std::string(name_of(tool.kind))) << '\n';
  if (tool.port) out << "port = " << list(*tool.port) << '\n';
  if (!tool.port_name.empty()) out << "port = " << toml_text(tool.port_name) << '\n';
  if (tool.friction) out << "friction = " << toml_real(*tool.friction) << '\n';
  if (tool.max_grip) out << "max_grip = " << toml_real(*tool.max_grip) << "  # N\n";
  out << "power = " << toml_real(tool.power) << "  # W\n";
  if (tool.poses.empty())
    write_keys(out, tool);
  else
    out << "poses = " << toml_text(tool.poses.string()) << '\n';
}

}  // namespace

void write_scene(std::ostream& out, const Scene& scene) {
  write_general(out, scene);
  write_shapes(out, scene);
  write_regions(out, scene);
  for (const SceneInstrument& tool : scene.instruments) write_instrument(out, tool);
  const SceneHaptics& haptics = scene.haptics;
  if (!haptics.instrument.empty())
    out << "\n[haptics]\ninstrument = " << toml_text(haptics.instrument)
        << "\nstiffness = " << toml_real(haptics.stiffness) << "  # N/m\ndamping = " << toml_real(haptics.damping)
        << "  # N s/m\nmax_force = " << toml_real(haptics.max_force) << "  # N\n";
  if (scene.camera)
    out << "\n[camera]\neye = " << list(scene.camera->eye) << "\ntarget = " << list(scene.camera->target)
        << "\nup = " << list(scene.camera->up) << "\n";
}

}  // namespace calot
