#include "calot/fem/model_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <toml.hpp>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/toml_file.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t size_limit = std::uint64_t{256} << 20;  // lists of supports can be long

std::string number_text(double value) {
  std::array<char, 40> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

/// The model as the file builds it up.
class ModelReader {
 public:
  explicit ModelReader(const fs::path& path) : toml_(path, size_limit) {}

  Model read() {
    const toml::value& root = toml_.root();
    toml_.allow_only(root, {"mesh", "length_unit", "region_names", "time_step", "rayleigh_mass", "rayleigh_stiffness",
                            "mass_lumping", "total_mass", "vertex_masses", "stiffness_scale", "material", "fixed"});
    const Dynamics dynamics = read_dynamics();
    const std::optional<double> total_mass = read_total_mass(dynamics);
    read_mesh_file();
    name_regions();
    for (const toml::value& table : toml_.tables("material")) read_material(table);
    check_materials();
    fixed_.assign(mesh_.vertex_count(), 0);
    for (const toml::value& table : toml_.tables("fixed")) read_fixed(table);
    check_support(dynamics);
    const std::vector<double> masses = read_list("vertex_masses", mesh_.vertex_count(), "kg");
    const std::vector<double> scale = read_list("stiffness_scale", mesh_.tet_count(), "(a factor)");
    if (!masses.empty() && dynamics.mass_lumping != MassLumping::uniform)
      toml_.fail(*detail::TomlFile::find(root, "vertex_masses"), "vertex_masses needs mass_lumping = \"uniform\"",
                 "leave it out or change mass_lumping");
    Model model(std::move(mesh_), std::move(materials_), std::move(fixed_), dynamics, total_mass,
                {toml_.path(), mesh_path_, sha256_of_file(mesh_path_)});
    if (!masses.empty()) model.set_vertex_masses(masses);
    if (!scale.empty()) {
      std::vector<TetId> all(scale.size());
      for (std::size_t t = 0; t < all.size(); ++t) all[t] = TetId(t);
      (void)model.scale_stiffness(all, scale);
    }
    return model;
  }

 private:
  double read_non_negative(const std::string& key, double otherwise) const {
    const toml::value* value = detail::TomlFile::find(toml_.root(), key);
    if (value == nullptr) return otherwise;
    const double number = toml_.number(*value, key);
    if (number < 0) toml_.fail(*value, key + " = " + number_text(number) + " is negative", "give a number ≥ 0");
    return number;
  }

  [[nodiscard]] Dynamics read_dynamics() const {
    Dynamics dynamics;
    dynamics.time_step = read_non_negative("time_step", dynamics.time_step);
    dynamics.rayleigh_mass = read_non_negative("rayleigh_mass", 0);
    dynamics.rayleigh_stiffness = read_non_negative("rayleigh_stiffness", 0);
    if (const toml::value* value = detail::TomlFile::find(toml_.root(), "mass_lumping")) {
      const std::string& name = toml_.text(*value, "mass_lumping");
      if (name != "element" && name != "uniform")
        toml_.fail(*value, "unknown mass_lumping \"" + name + "\"", "use \"element\" or \"uniform\"");
      dynamics.mass_lumping = name == "uniform" ? MassLumping::uniform : MassLumping::element;
    }
    return dynamics;
  }

  [[nodiscard]] std::optional<double> read_total_mass(const Dynamics& dynamics) const {
    const toml::value* value = detail::TomlFile::find(toml_.root(), "total_mass");
    if (value == nullptr) return {};
    if (dynamics.mass_lumping != MassLumping::uniform)
      toml_.fail(*value, "total_mass needs mass_lumping = \"uniform\"", "leave it out or change mass_lumping");
    const double mass = toml_.number(*value, "total_mass");
    if (mass <= 0) toml_.fail(*value, "total_mass = " + number_text(mass) + " must be > 0 kg", "give the mass in kg");
    return mass;
  }

  /// `count` numbers > 0, or none where the key is absent.
  [[nodiscard]] std::vector<double> read_list(const std::string& key, std::size_t count, const char* unit) const {
    std::vector<double> values;
    const toml::value* list = detail::TomlFile::find(toml_.root(), key);
    if (list == nullptr) return values;
    for (const toml::value& entry : toml_.array(*list, key)) {
      values.push_back(toml_.number(entry, key));
      if (!(values.back() > 0))
        toml_.fail(entry, key + " holds " + number_text(values.back()), std::string("give numbers > 0 ") + unit);
    }
    if (values.size() != count)
      toml_.fail(*list,
                 key + " has " + std::to_string(values.size()) + " values, the mesh needs " + std::to_string(count),
                 "leave it out or give one for each");
    return values;
  }

  void read_mesh_file() {
    const toml::value& name = toml_.need(toml_.root(), "mesh", "\"organ.msh\"");
    if (const toml::value* unit = detail::TomlFile::find(toml_.root(), "length_unit"))
      metres_ = metres_per(unit_ = toml_.text(*unit, "length_unit"), toml_.at(*unit));
    mesh_path_ = toml_.path().parent_path() / toml_.text(name, "mesh");
    std::error_code code;
    if (!fs::is_regular_file(mesh_path_, code))
      toml_.fail(name, "no mesh file " + mesh_path_.string(), "name it relative to the model file");
    mesh_ = read_mesh(mesh_path_, metres_).mesh;
    present_ = {mesh_.regions.begin(), mesh_.regions.end()};
  }

  void name_regions() {
    const toml::value* names = detail::TomlFile::find(toml_.root(), "region_names");
    if (names == nullptr) return;
    if (!names->is_table()) toml_.fail(*names, "region_names must be a table", "write { 2 = \"liver\" }");
    for (const auto& [key, value] : names->as_table()) {
      std::int32_t region = 0;
      const auto [end, code] = std::from_chars(key.data(), key.data() + key.size(), region);
      if (code != std::errc() || end != key.data() + key.size())
        toml_.fail(value, "\"" + key + "\" is not a region number", "write { 2 = \"liver\" }");
      if (!present_.contains(region)) (void)regions_matching(mesh_, key, toml_.at(value) + ": region_names");
      mesh_.region_names[region] = toml_.text(value, "the name of region " + key);
    }
  }

  [[nodiscard]] std::vector<std::int32_t> regions_of(const toml::value& value) const {
    const std::string name = value.is_integer() ? std::to_string(value.as_integer()) : toml_.text(value, "region");
    return regions_matching(mesh_, name, toml_.at(value));
  }

  void read_material(const toml::value& table) {
    toml_.allow_only(table, {"region", "young", "poisson", "density"});
    const toml::value& young = toml_.need(table, "young", "1.0e6  # Pa");
    const toml::value& poisson = toml_.need(table, "poisson", "0.45");
    Material material;
    material.young = toml_.number(young, "young");
    material.poisson = toml_.number(poisson, "poisson");
    if (material.young <= 0)
      toml_.fail(young, "young = " + number_text(material.young) + " must be > 0 Pa", "give Young's modulus in Pa");
    if (material.poisson <= -1 || material.poisson >= 0.5)
      toml_.fail(poisson, "poisson = " + number_text(material.poisson) + " must lie between -1 and 0.5",
                 "use e.g. 0.45 for soft tissue");
    if (const toml::value* density = detail::TomlFile::find(table, "density")) {
      material.density = toml_.number(*density, "density");
      if (material.density <= 0)
        toml_.fail(*density, "density = " + number_text(material.density) + " must be > 0 kg/m3", "use e.g. 1000");
    }
    for (const std::int32_t region : regions_of(toml_.need(table, "region", "\"*\""))) materials_[region] = material;
  }

  void check_materials() const {
    for (const std::int32_t region : present_) {
      if (materials_.contains(region)) continue;
      const auto name = mesh_.region_names.find(region);
      throw InputError(toml_.path().string(),
                       "region " + std::to_string(region) +
                           (name == mesh_.region_names.end() ? "" : " (" + name->second + ")") + " has no material",
                       "add a [[material]] for it or for \"*\"");
    }
  }

  void read_fixed(const toml::value& table) {
    toml_.allow_only(table, {"vertices", "box", "region"});
    if (table.as_table().size() != 1)
      toml_.fail(table, "a [[fixed]] needs one of vertices, box and region", "write a [[fixed]] for each");
    if (const toml::value* vertices = detail::TomlFile::find(table, "vertices")) fix_vertices(*vertices);
    if (const toml::value* box = detail::TomlFile::find(table, "box")) fix_box(*box);
    if (const toml::value* region = detail::TomlFile::find(table, "region")) fix_region(*region);
  }

  void fix_vertices(const toml::value& list) {
    const std::size_t count = mesh_.vertex_count();
    for (const toml::value& entry : toml_.array(list, "vertices")) {
      if (!entry.is_integer()) toml_.fail(entry, "a vertex number must be a whole number", "count from 0");
      const std::int64_t number = entry.as_integer();
      if (number < 0 || static_cast<std::uint64_t>(number) >= count)
        toml_.fail(entry, "vertex " + std::to_string(number) + " is not in the mesh",
                   "use 0 to " + std::to_string(count - 1));
      fixed_[static_cast<std::size_t>(number)] = 1;
    }
  }

  Vec3 corner(const toml::value& box, const std::string& key) const {
    const toml::value& value = toml_.need(box, key, "[0.0, 0.0, 0.0]");
    const auto& list = toml_.array(value, key);
    if (list.size() != 3) toml_.fail(value, key + " needs three numbers", "write [x, y, z]");
    Vec3 point;
    for (std::size_t axis = 0; axis < 3; ++axis) point[static_cast<int>(axis)] = toml_.number(list[axis], key);
    return point;
  }

  void fix_box(const toml::value& box) {
    if (!box.is_table()) toml_.fail(box, "box must be a table", "write { min = [x, y, z], max = [x, y, z] }");
    toml_.allow_only(box, {"min", "max"});
    const Vec3 low = corner(box, "min"), high = corner(box, "max");
    if ((low.array() > high.array()).any()) toml_.fail(box, "the box is empty: min is above max", "exchange them");
    const std::vector<std::uint8_t> used = used_vertices();
    std::size_t caught = 0;
    Vec3 mesh_low = Vec3::Constant(HUGE_VAL), mesh_high = -mesh_low;
    for (std::size_t v = 0; v < used.size(); ++v) {
      const Vec3& p = mesh_.positions[v];
      mesh_low = mesh_low.cwiseMin(p);
      mesh_high = mesh_high.cwiseMax(p);
      // Scaled as the mesh was, so that a box drawn exactly through vertices catches them.
      const bool inside = (p.array() >= metres_ * low.array()).all() && (p.array() <= metres_ * high.array()).all();
      if (used[v] == 0 || !inside) continue;
      fixed_[v] = 1;
      ++caught;
    }
    if (caught > 0) return;
    toml_.fail(box, "the box catches no vertex",
               "the mesh reaches from " + point_text(mesh_low) + " to " + point_text(mesh_high) + " " + unit_);
  }

  void fix_region(const toml::value& value) {
    const std::vector<std::int32_t> regions = regions_of(value);
    for (std::size_t t = 0; t < mesh_.tet_count(); ++t)
      if (std::find(regions.begin(), regions.end(), mesh_.regions[t]) != regions.end())
        for (const VertexId v : mesh_.tets[t]) fixed_[v.index()] = 1;
  }

  void check_support(const Dynamics& dynamics) const {
    if (!dynamics.is_static()) return;
    const std::vector<std::uint8_t> used = used_vertices();
    for (std::size_t v = 0; v < used.size(); ++v)
      if (used[v] != 0 && fixed_[v] != 0) return;
    toml_.fail(*detail::TomlFile::find(toml_.root(), "time_step"),
               "a static model (time_step = 0) needs fixed vertices", "add a [[fixed]] or a time_step > 0");
  }

  [[nodiscard]] std::vector<std::uint8_t> used_vertices() const {
    std::vector<std::uint8_t> used(mesh_.vertex_count(), 0);
    for (const Tet& tet : mesh_.tets)
      for (const VertexId v : tet) used[v.index()] = 1;
    return used;
  }

  [[nodiscard]] std::string point_text(const Vec3& metres) const {
    std::ostringstream text;
    text.precision(4);
    text << '[' << metres[0] / metres_ << ", " << metres[1] / metres_ << ", " << metres[2] / metres_ << ']';
    return text.str();
  }

  detail::TomlFile toml_;
  fs::path mesh_path_;
  std::string unit_ = "m";
  double metres_ = 1;
  TetMesh mesh_;
  std::set<std::int32_t> present_;  // regions that tets carry
  std::map<std::int32_t, Material> materials_;
  std::vector<std::uint8_t> fixed_;
};

// ---- writing ----

/// The shortest text that reads back to the same double and is a TOML float.
std::string real(double value) {
  std::string text = number_text(value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << '"';
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out << '\\' << c;
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      out << "\\u00"
          << "0123456789abcdef"[c >> 4] << "0123456789abcdef"[c & 15];
    else
      out << c;
  }
  return out.str() + '"';
}

/// A total mass whose share, total / count, is the given one: to the last bit where a double can do that.
double total_for_share(double share, double count) {
  const double product = share * count;
  double best = product, candidate = product;
  for (const double direction : {0.0, HUGE_VAL}) {
    candidate = product;
    for (int step = 0; step < 4; ++step) {
      if (std::abs(candidate / count - share) < std::abs(best / count - share)) best = candidate;
      candidate = std::nextafter(candidate, direction);
    }
  }
  return best;
}

void write_region_names(std::ostream& out, const TetMesh& mesh, const std::set<std::int32_t>& present) {
  std::string names;
  for (const auto& [region, name] : mesh.region_names)
    if (present.contains(region)) names += (names.empty() ? "" : ", ") + std::to_string(region) + " = " + quoted(name);
  if (!names.empty()) out << "region_names = { " << names << " }\n";
}

void write_list(std::ostream& out, const char* key, const std::vector<double>& values) {
  constexpr std::size_t per_line = 8;
  out << key << " = [";
  for (std::size_t k = 0; k < values.size(); ++k) out << (k % per_line == 0 ? "\n  " : " ") << real(values[k]) << ',';
  out << "\n]\n";
}

void write_fixed(std::ostream& out, const std::vector<std::uint8_t>& fixed) {
  constexpr std::size_t per_line = 16;
  std::size_t written = 0;
  for (std::size_t v = 0; v < fixed.size(); ++v) {
    if (fixed[v] == 0) continue;
    if (written == 0) out << "\n[[fixed]]\nvertices = [";
    out << (written % per_line == 0 ? "\n  " : " ") << v << ',';
    ++written;
  }
  if (written > 0) out << "\n]\n";
}

}  // namespace

Model load_model(const fs::path& path) {
  return ModelReader(path).read();
}

void save_model(const fs::path& path, const Model& model, const std::string& mesh_name) {
  const Dynamics& dynamics = model.dynamics();
  const std::set<std::int32_t> present(model.mesh().regions.begin(), model.mesh().regions.end());
  write_file(path, [&](std::ostream& out) {
    out << "mesh = " << quoted(mesh_name) << "\nlength_unit = \"m\"\n";
    write_region_names(out, model.mesh(), present);
    out << "time_step = " << real(dynamics.time_step) << "  # s\n"
        << "rayleigh_mass = " << real(dynamics.rayleigh_mass) << "  # 1/s\n"
        << "rayleigh_stiffness = " << real(dynamics.rayleigh_stiffness) << "  # s\n";
    out << "mass_lumping = \"" << (dynamics.mass_lumping == MassLumping::uniform ? "uniform" : "element") << "\"\n";
    if (!model.has_even_masses())
      write_list(out, "vertex_masses", model.vertex_masses());
    else if (dynamics.mass_lumping == MassLumping::uniform)
      out << "total_mass = "
          << real(total_for_share(model.uniform_share(), static_cast<double>(model.mesh().vertex_count())))
          << "  # kg\n";
    if (model.has_scaled_stiffness()) write_list(out, "stiffness_scale", model.stiffness_scale());
    for (const auto& [region, material] : model.materials())
      if (present.contains(region))
        out << "\n[[material]]\nregion = " << region << "\nyoung = " << real(material.young)
            << "  # Pa\npoisson = " << real(material.poisson) << "\ndensity = " << real(material.density)
            << "  # kg/m3\n";
    write_fixed(out, model.fixed());
  });
}

}  // namespace calot
