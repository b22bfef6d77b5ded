#include <algorithm>
#include <cmath>
#include <set>

#include "calot/mesh/mesh_file.h"
#include "calot/patient/centreline_file.h"
#include "calot/patient/import_options.h"
#include "calot/patient/line_place.h"
#include "calot/patient/patient_file.h"

namespace calot::detail {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t size_limit = std::uint64_t{16} << 20;
constexpr std::size_t most_problems = 20;
constexpr double mm = 1e-3;
constexpr double farthest = 1e4;  // [mm]: no body is larger

std::vector<std::string> structure_words() {
  std::vector<std::string> words;
  for (const Structure s : all_structures()) words.emplace_back(name_of(s));
  return words;
}

/// Whether text would do something to a terminal instead of being shown.
bool has_control(const std::string& text) {
  return std::any_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

}  // namespace

PatientReader::PatientReader(const fs::path& folder) : folder_(folder), toml_(folder / "patient.toml", size_limit) {}

template <class Work>
void PatientReader::guarded(const Work& work) {
  if (problems_.size() >= most_problems) return;
  try {
    work();
  } catch (const InputError& wrong) {
    problems_.push_back(wrong);
  }
}

template <class Read>
void PatientReader::each(const std::string& name, const Read& read) {
  guarded([&] {
    for (const toml::value& table : toml_.tables(name)) guarded([&] { read(table); });
  });
}

// ---- values ----

Vec3 PatientReader::place(const toml::value& value, const std::string& key) const {
  const Vec3 point = toml_.point(value, key);
  if (point.cwiseAbs().maxCoeff() > farthest)
    toml_.fail(value, key + " lies more than 10 m away", "give RAS millimetres");
  return mm * point;
}

Vec3 PatientReader::direction(const toml::value& value, const std::string& key) const {
  const Vec3 vector = toml_.point(value, key);
  const double size = vector.stableNorm();
  if (!(size > 1e-6 && size < 1e6)) toml_.fail(value, key + " has no direction", "give e.g. [0.0, 0.0, 1.0]");
  return vector / size;
}

Vec3 PatientReader::need_point(const toml::value& table, const std::string& key) const {
  return place(toml_.need(table, key, "[12.5, -3.0, 41.0]  # RAS mm"), key);
}

double PatientReader::need_number(const toml::value& table, const std::string& key, double low, double high,
                                  const std::string& unit) const {
  return toml_.number_in(toml_.need(table, key, short_number(high)), key, low, high, unit);
}

std::string PatientReader::need_text(const toml::value& table, const std::string& key,
                                     const std::string& example) const {
  return toml_.text(toml_.need(table, key, toml_text(example)), key);
}

Structure PatientReader::structure(const toml::value& value, const std::string& key) const {
  const std::string& text = toml_.text(value, key);
  if (const auto found = structure_named(plain_name(text))) return *found;
  toml_.fail(value, "there is no structure \"" + brief(text) + "\"", suggestion(plain_name(text), structure_words()));
}

// ---- header, files, regions ----

PatientFiles PatientReader::read_files() {
  guarded([&] {
    toml_.allow_only(toml_.root(),
                     {"format", "name", "made_by", "orientation", "length_unit", "files", "region", "attachment",
                      "border_cut", "port", "camera", "clip", "cut", "calot_triangle", "landmarks"});
  });
  guarded([&] { read_header(); });
  guarded([&] {
    const toml::value& files = toml_.need(toml_.root(), "files", "{ mesh = \"mesh.msh\" }");
    if (!files.is_table()) toml_.fail(files, "files must be a section", "write [files]");
    toml_.allow_only(files, {"mesh", "model", "centrelines", "labels", "quality", "provenance"});
    files_.mesh = file_name(toml_.need(files, "mesh", "\"mesh.msh\""), "mesh");
    const auto optional = [&](const std::string& key, std::string& name) {
      if (const toml::value* value = TomlFile::find(files, key)) name = file_name(*value, key);
    };
    optional("model", files_.model);
    optional("centrelines", files_.centrelines);
    optional("labels", files_.labels);
    optional("quality", files_.quality);
    optional("provenance", files_.provenance);
  });
  each("region", [&](const toml::value& table) { read_region(table); });
  return files_;
}

void PatientReader::read_header() {
  const toml::value& root = toml_.root();
  const toml::value& format = toml_.need(root, "format", "1");
  if (toml_.whole(format, "format") != 1)
    toml_.fail(format, "format " + std::to_string(format.as_integer()) + " is not one that this program reads",
               "use a newer Calot, or make the folder anew with calot patient");
  const toml::value& name = toml_.need(root, "name", "\"patient\"");
  patient_.name = toml_.text(name, "name");
  if (patient_.name.find_first_not_of(' ') == std::string::npos)
    toml_.fail(name, "the patient's name is empty", "give one, e.g. name = \"patient\"");
  if (has_control(patient_.name))
    toml_.fail(name, "name = \"" + brief(patient_.name) + "\" has control characters", "write it in one line of text");
  const auto must_be = [&](const std::string& key, const std::string& only) {
    const toml::value* value = TomlFile::find(root, key);
    if (value != nullptr && toml_.text(*value, key) != only)
      toml_.fail(*value, key + " must be \"" + only + "\"", "convert the places in this file");
  };
  must_be("orientation", "RAS");
  must_be("length_unit", "mm");
  if (const toml::value* made_by = TomlFile::find(root, "made_by")) (void)toml_.text(*made_by, "made_by");
}

/// A name relative to the folder, and within it: a patient's folder can be moved.
std::string PatientReader::file_name(const toml::value& value, const std::string& key) const {
  const std::string& name = toml_.text(value, key);
  const fs::path path(name);
  const bool inside = !name.empty() && path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end() &&
                      !has_control(name);
  if (!inside) toml_.fail(value, key + " = \"" + brief(name) + "\" is not a file of this folder", "put it there");
  return name;
}

void PatientReader::read_region(const toml::value& table) {
  toml_.allow_only(table, {"label", "name", "surface", "young", "poisson", "density", "source", "colour",
                           "texture_size", "blend_sharpness"});
  const toml::value& name = toml_.need(table, "name", "\"liver\"");
  const Structure s = structure(name, "name");
  const toml::value& label = toml_.need(table, "label", std::to_string(label_of(s)));
  if (toml_.whole(label, "label") != label_of(s))
    toml_.fail(label, "label " + std::to_string(label.as_integer()) + " is not that of " + std::string(name_of(s)),
               "write label = " + std::to_string(label_of(s)));
  const std::size_t line = table.location().line();
  if (const auto [other, fresh] = region_lines_.emplace(s, line); !fresh)
    toml_.fail(table,
               "a second [[region]] for " + std::string(name_of(s)) + ", after line " + std::to_string(other->second),
               "keep one of them");
  if (const toml::value* surface = TomlFile::find(table, "surface"))
    files_.surfaces[s] = file_name(*surface, "surface");
  TissueMaterial& material = patient_.materials[s];
  const toml::value& young = toml_.need(table, "young", "5400.0  # Pa");
  material.young = toml_.number(young, "young");
  if (material.young <= 0)
    toml_.fail(young, "young = " + short_number(material.young) + " must be > 0 Pa", "give Young's modulus in Pa");
  const toml::value& poisson = toml_.need(table, "poisson", "0.45");
  material.poisson = toml_.number(poisson, "poisson");
  if (material.poisson <= -1 || material.poisson >= 0.5)
    toml_.fail(poisson, "poisson = " + short_number(material.poisson) + " must lie between -1 and 0.5",
               "use e.g. 0.45 for soft tissue");
  const toml::value& density = toml_.need(table, "density", "1060.0  # kg/m3");
  material.density = toml_.number(density, "density");
  if (material.density <= 0)
    toml_.fail(density, "density = " + short_number(material.density) + " must be > 0 kg/m3", "use e.g. 1000");
  if (const toml::value* source = TomlFile::find(table, "source")) material.source = toml_.text(*source, "source");
  Appearance look = appearance_of(s);
  if (const toml::value* colour = TomlFile::find(table, "colour")) {
    const Vec3 rgb = toml_.point(*colour, "colour");
    if (rgb.minCoeff() < 0 || rgb.maxCoeff() > 1)
      toml_.fail(*colour, "colour is out of range", "give red, green and blue from 0 to 1");
    look.red = rgb[0], look.green = rgb[1], look.blue = rgb[2];
  }
  if (const toml::value* size = TomlFile::find(table, "texture_size"))
    look.texture_size = mm * toml_.number_in(*size, "texture_size", 0.1, 1000, "mm");
  if (const toml::value* sharpness = TomlFile::find(table, "blend_sharpness"))
    look.blend_sharpness = toml_.number_in(*sharpness, "blend_sharpness", 1, 64, "");
  patient_.appearances[s] = look;
}

/// Regions of the file against those of the mesh.
void PatientReader::check_regions() {
  const std::set<std::int32_t> present(patient_.mesh.regions.begin(), patient_.mesh.regions.end());
  for (const std::int32_t region : present)
    guarded([&] {
      for (const auto& [s, line] : region_lines_)
        if (label_of(s) == region) return;
      std::string text = std::to_string(region);
      if (const auto name = patient_.mesh.region_names.find(region); name != patient_.mesh.region_names.end())
        text += " (" + brief(name->second) + ")";
      throw InputError(toml_.path().string(), "region " + text + " of the mesh has no [[region]]", "add one");
    });
  for (const auto& entry : region_lines_)
    guarded([&] {
      const Structure s = entry.first;
      if (!present.contains(label_of(s)))
        throw InputError(at_line(toml_.path().string(), entry.second),
                         "the mesh has no region " + std::to_string(label_of(s)) + " (" + std::string(name_of(s)) + ")",
                         "remove this [[region]], or restore the mesh");
    });
}

// ---- the rest ----

Patient PatientReader::read() {
  guarded([&] {
    if (files_.mesh.empty()) return;  // was complained about
    patient_.mesh = read_mesh(folder_ / files_.mesh, mm).mesh;
  });
  guarded([&] {
    if (!files_.centrelines.empty()) patient_.lines = read_centrelines(folder_ / files_.centrelines);
  });
  if (!problems_.empty()) return {};  // what follows would only echo them
  tubes_ = lines_towards_gallbladder(patient_.lines, patient_.mesh);
  check_regions();
  each("attachment", [&](const toml::value& table) { read_attachment(table); });
  each("border_cut", [&](const toml::value& table) { read_border_cut(table); });
  each("port", [&](const toml::value& table) { read_port(table); });
  each("clip", [&](const toml::value& table) { patient_.landmarks.clips.push_back(read_site(table)); });
  each("cut", [&](const toml::value& table) { patient_.landmarks.cuts.push_back(read_site(table)); });
  const auto section = [&](const std::string& name, bool needed, const auto& read) {
    guarded([&] {
      if (const toml::value* table = toml_.section(name))
        read(*table);
      else if (needed)
        throw InputError(toml_.path().string(), "[" + name + "] is missing", "add it (docs/formats.md)");
    });
  };
  section("camera", true, [&](const toml::value& table) { read_camera(table); });
  section("calot_triangle", true, [&](const toml::value& table) { read_triangle(table); });
  section("landmarks", false, [&](const toml::value& table) { read_notes(table); });
  return std::move(patient_);
}

void PatientReader::read_attachment(const toml::value& table) {
  toml_.allow_only(table, {"name", "kind", "reason", "vertices"});
  Attachment attachment;
  attachment.name = need_text(table, "name", "liver: bare area");
  const toml::value& kind = toml_.need(table, "kind", "\"fixed\"");
  const std::string& word = toml_.text(kind, "kind");
  if (word != "fixed" && word != "peritoneum")
    toml_.fail(kind, "there is no kind \"" + brief(word) + "\"", suggestion(word, {"fixed", "peritoneum"}));
  attachment.kind = word == "fixed" ? AttachmentKind::fixed : AttachmentKind::peritoneum;
  if (const toml::value* reason = TomlFile::find(table, "reason")) attachment.reason = toml_.text(*reason, "reason");
  const toml::value& list = toml_.need(table, "vertices", "[0, 17, 18]");
  const std::size_t count = patient_.mesh.vertex_count();
  for (const toml::value& entry : toml_.array(list, "vertices")) {
    const std::int64_t number = toml_.whole(entry, "a vertex number");
    if (number < 0 || static_cast<std::uint64_t>(number) >= count)
      toml_.fail(entry, "vertex " + std::to_string(number) + " is not in the mesh",
                 "use 0 to " + std::to_string(count - 1));
    attachment.vertices.emplace_back(static_cast<std::size_t>(number));
  }
  if (attachment.vertices.empty())
    toml_.fail(list, "\"" + brief(attachment.name) + "\" holds no vertex", "name some, or remove the [[attachment]]");
  std::sort(attachment.vertices.begin(), attachment.vertices.end());
  attachment.vertices.erase(std::unique(attachment.vertices.begin(), attachment.vertices.end()),
                            attachment.vertices.end());
  patient_.attachments.push_back(std::move(attachment));
}

void PatientReader::read_border_cut(const toml::value& table) {
  toml_.allow_only(table, {"structure", "axis", "upper", "point", "normal", "area"});
  BorderCut cut;
  cut.structure = structure(toml_.need(table, "structure", "\"liver\""), "structure");
  const toml::value& axis = toml_.need(table, "axis", "\"k\"");
  const std::string& letter = toml_.text(axis, "axis");
  if (letter != "i" && letter != "j" && letter != "k")
    toml_.fail(axis, "there is no axis \"" + brief(letter) + "\"", "use \"i\", \"j\" or \"k\"");
  cut.axis = letter[0] - 'i';
  const toml::value& upper = toml_.need(table, "upper", "true");
  if (!upper.is_boolean()) toml_.fail(upper, "upper must be true or false", "write upper = true");
  cut.upper = upper.as_boolean();
  cut.point = need_point(table, "point");
  cut.normal = direction(toml_.need(table, "normal", "[0.0, 0.0, 1.0]"), "normal");
  cut.area = 1e-6 * need_number(table, "area", 0, 1e8, "mm2");
  patient_.border_cuts.push_back(cut);
}

void PatientReader::read_port(const toml::value& table) {
  toml_.allow_only(table, {"name", "position", "diameter", "purpose"});
  Port port;
  port.name = need_text(table, "name", "epigastric");
  port.position = need_point(table, "position");
  port.diameter = mm * need_number(table, "diameter", 2, 20, "mm");
  if (const toml::value* purpose = TomlFile::find(table, "purpose")) port.purpose = toml_.text(*purpose, "purpose");
  patient_.landmarks.ports.push_back(std::move(port));
}

void PatientReader::read_camera(const toml::value& table) {
  toml_.allow_only(table, {"tip", "target", "up", "oblique", "field_of_view"});
  CameraPose& camera = patient_.landmarks.camera;
  camera.tip = need_point(table, "tip");
  camera.target = need_point(table, "target");
  camera.up = direction(toml_.need(table, "up", "[0.0, 0.0, 1.0]"), "up");
  camera.oblique = need_number(table, "oblique", 0, 90, "degrees");
  camera.field_of_view = need_number(table, "field_of_view", 10, 150, "degrees");
  const Vec3 gaze = camera.target - camera.tip;
  if (gaze.norm() < 1 * mm) toml_.fail(table, "the camera's target is where its tip is", "move one of them");
  if (gaze.normalized().cross(camera.up).norm() < 1e-3)
    toml_.fail(table, "the camera's up points along its view", "choose another up, e.g. [0.0, 0.0, 1.0]");
}

void PatientReader::read_triangle(const toml::value& table) {
  toml_.allow_only(table, {"duct_corner", "neck_corner", "liver_corner"});
  CalotTriangle& triangle = patient_.landmarks.triangle;
  triangle.duct_corner = need_point(table, "duct_corner");
  triangle.neck_corner = need_point(table, "neck_corner");
  triangle.liver_corner = need_point(table, "liver_corner");
}

void PatientReader::read_notes(const toml::value& table) {
  toml_.allow_only(table, {"notes"});
  if (const toml::value* notes = TomlFile::find(table, "notes"))
    for (const toml::value& note : toml_.array(*notes, "notes"))
      patient_.landmarks.notes.push_back(toml_.text(note, "a note"));
}

// ---- clips and cuts ----

TubeSite PatientReader::read_site(const toml::value& table) const {
  toml_.allow_only(table, {"name", "tube", "arc_length", "position", "direction", "radius"});
  TubeSite site;
  site.name = need_text(table, "name", "cystic duct, clip 1");
  const toml::value& tube = toml_.need(table, "tube", "\"cystic duct\"");
  site.tube = structure(tube, "tube");
  if (!is_tube(site.tube))
    toml_.fail(tube, std::string(name_of(site.tube)) + " is not a duct or an artery", "name the tube that is meant");
  complete_site(site, table);
  return site;
}

/// What isn't given comes from the centreline.
void PatientReader::complete_site(TubeSite& site, const toml::value& table) const {
  const toml::value* arc = TomlFile::find(table, "arc_length");
  const toml::value* position = TomlFile::find(table, "position");
  const toml::value* along = TomlFile::find(table, "direction");
  const toml::value* radius = TomlFile::find(table, "radius");
  if (arc != nullptr) site.arc_length = mm * toml_.number_in(*arc, "arc_length", 0, farthest, "mm");
  if (position != nullptr) site.position = place(*position, "position");
  if (along != nullptr) site.direction = direction(*along, "direction");
  if (radius != nullptr) site.radius = mm * toml_.number_in(*radius, "radius", 0.05, 20, "mm");
  if (arc == nullptr && position == nullptr)
    toml_.fail(table, "\"" + brief(site.name) + "\" has neither arc_length nor position", "give one of them");
  if (arc != nullptr && position != nullptr && along != nullptr && radius != nullptr) return;
  const auto line = tubes_.find(site.tube);
  if (line == tubes_.end())
    toml_.fail(table,
               "there is no centreline of the " + std::string(name_of(site.tube)) + " to place \"" + brief(site.name) +
                   "\" on",
               "give arc_length, position, direction and radius");
  if (arc == nullptr) site.arc_length = project(line->second, site.position).arc_length;
  const LinePlace found = place_at(line->second, site.arc_length);
  if (position == nullptr) site.position = found.point;
  if (along == nullptr) site.direction = found.direction;
  if (radius == nullptr) site.radius = found.radius;
}

}  // namespace calot::detail

namespace calot {

Patient load_patient(const std::filesystem::path& folder) {
  std::error_code code;
  if (!std::filesystem::is_directory(folder, code))
    throw InputError(folder.string(), "there is no such folder", "name a folder that calot patient wrote");
  detail::PatientReader reader(folder);
  reader.read_files();
  Patient patient = reader.read();
  if (!reader.problems().empty()) throw InputError(reader.problems().front());
  return patient;
}

}  // namespace calot
