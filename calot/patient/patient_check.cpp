#include "calot/patient/patient_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "calot/base/files.h"
#include "calot/mesh/mesh_file.h"
#include "calot/patient/json_file.h"

namespace calot {
namespace fs = std::filesystem;
namespace detail {
namespace {

constexpr std::uint64_t json_limit = std::uint64_t{16} << 20;
const std::string restore = "restore it, or make the folder anew with calot patient";

/// Findings are one line each, whatever a file holds: no line breaks, no escape sequences.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

/// An error's line, "where: what; what to do", in its parts.
Finding finding_of(const Error& error, const fs::path& folder) {
  std::string text = error.what();
  const std::string prefix = folder.string() + "/";
  if (text.starts_with(prefix)) text.erase(0, prefix.size());
  Finding finding;
  if (const auto place = text.find(": "); place != std::string::npos) {
    finding.where = text.substr(0, place);
    text.erase(0, place + 2);
  }
  const auto place = text.find("; ");
  finding.what = text.substr(0, place);
  if (place != std::string::npos) finding.what_to_do = text.substr(place + 2);
  return finding;
}

/// The files of a folder: there, and as they were written.
class FileCheck {
 public:
  /// @param all_read  false where patient.toml has mistakes: a name that isn't there may be one of them
  FileCheck(const fs::path& folder, const PatientFiles& files, bool all_read, Findings& findings)
      : folder_(folder), files_(files), all_read_(all_read), findings_(findings) {}

  void check() {
    check_named("centrelines", files_.centrelines, "centrelines.mrk.json");
    check_named("labels", files_.labels, "labels.nii.gz");
    check_named("model", files_.model, "model.toml");
    check_named("quality", files_.quality, "quality.json");
    check_named("provenance", files_.provenance, "provenance.json");
    if (!files_.mesh.empty()) check_there(files_.mesh);  // PatientReader asks for it
    for (const auto& [s, name] : files_.surfaces) check_there(name);
    if (good(files_.provenance)) check_hashes();
  }

  /// False if a file is missing or not the one that was written.
  [[nodiscard]] bool good(const std::string& name) const { return !name.empty() && !bad_.contains(name); }

 private:
  /// Without a name nothing looks at the file, whatever is wrong with it.
  void check_named(const std::string& key, const std::string& name, const std::string& usual) {
    if (name.empty() && all_read_)
      findings_.error("patient.toml, files", "\"" + key + "\" is missing: nothing vouches for that file",
                      "add " + key + " = \"" + usual + "\"");
    if (!name.empty()) check_there(name);
  }

  void check_there(const std::string& name) {
    std::error_code code;
    if (bad_.contains(name) || fs::is_regular_file(folder_ / name, code)) return;
    findings_.error(brief(name), "the file is missing", restore);
    bad_.insert(name);
  }

  void check_hashes() {
    try {
      const Json json = read_json(folder_ / files_.provenance, json_limit);
      const auto files = json.is_object() ? json.find("files") : json.end();
      if (!json.is_object() || files == json.end() || !files->is_object())
        throw InputError((folder_ / files_.provenance).string(), "has no \"files\" with hashes", restore);
      for (const auto& [name, hash] : files->items()) check_hash(name, hash);
      check_hashed(files_.mesh, *files);
      for (const std::string* name : {&files_.centrelines, &files_.labels, &files_.quality})
        check_hashed(*name, *files);
      for (const auto& [s, name] : files_.surfaces) check_hashed(name, *files);
    } catch (const Error& error) {
      findings_.list.push_back(finding_of(error, folder_));
      bad_.insert(files_.provenance);
    }
  }

  /// model.toml and patient.toml have no hash: they are meant to be changed.
  void check_hashed(const std::string& name, const Json& files) {
    if (good(name) && !files.contains(name))
      findings_.error(brief(name),
                      "has no hash in " + brief(files_.provenance) + ": it was exchanged, or its hash removed",
                      restore);
  }

  void check_hash(const std::string& name, const Json& hash) {
    const fs::path path(name);
    if (name.empty() || !path.is_relative() || name.find('\0') != std::string::npos ||
        std::find(path.begin(), path.end(), "..") != path.end()) {
      findings_.error(brief(files_.provenance),
                      std::string("\"").append(brief(name)) + "\" is not a file of this folder", restore);
      return;
    }
    check_there(name);
    if (bad_.contains(name) || hash == sha256_of_file(folder_ / name)) return;
    bad_.insert(name);
    const std::string changed =
        "was changed after the folder was made (its hash differs from " + brief(files_.provenance) + ")";
    if (name == files_.mesh)
      findings_.error(brief(name), changed + "; attachments and landmarks no longer fit, and nothing else was checked",
                      restore);
    else if (name == files_.centrelines)
      findings_.warning(brief(name), changed,
                        "if you meant to: calot patient draws the tubes anew, clips alone don't move them");
    else if (name == files_.labels || is_surface(name))
      findings_.error(brief(name), changed + " and no longer fits the mesh", restore);
    else
      findings_.warning(brief(name), changed, restore);
  }

  [[nodiscard]] bool is_surface(const std::string& name) const {
    return std::any_of(files_.surfaces.begin(), files_.surfaces.end(),
                       [&](const auto& surface) { return surface.second == name; });
  }

  const fs::path& folder_;
  const PatientFiles& files_;
  bool all_read_;
  Findings& findings_;
  std::set<std::string> bad_;
};

// ---- surfaces ----

/// That a surface can be drawn, and is one of its organ: hashes only say that it is the one that was written.
void check_surface(const fs::path& folder, const std::string& file, Structure s, const TetMesh& mesh,
                   Findings& findings) {
  constexpr double slack = 1e-5;  // [m]: some formats hold single precision only
  const Surface surface = read_surface(folder / file, 1e-3);
  if (surface.triangles.empty()) {
    findings.error(brief(file), "holds no triangle", restore);
    return;
  }
  Eigen::AlignedBox3d box;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (mesh.regions[t] == label_of(s))
      for (const VertexId v : mesh.tets[t]) box.extend(mesh.position(v));
  const auto outside = std::find_if(surface.positions.begin(), surface.positions.end(),
                                    [&](const Vec3& p) { return !(box.exteriorDistance(p) <= slack); });
  if (outside != surface.positions.end())
    findings.error(brief(file),
                   "is not the surface of the " + std::string(name_of(s)) + ": a vertex lies " +
                       mm_text(box.exteriorDistance(*outside)) + " away from the box around it in the mesh",
                   restore);
}

// ---- quality.json ----

/// A key's number; NaN where there is none.
double number_in(const Json& json, const char* key) {
  if (!json.is_object()) return std::nan("");
  const auto value = json.find(key);
  return value != json.end() && value->is_number() ? value->get<double>() : std::nan("");
}

bool describes(const Json& json, const Quality& q) {
  return number_in(json, "vertices") == static_cast<double>(q.vertices) &&
         number_in(json, "tets") == static_cast<double>(q.tets) &&
         std::abs(number_in(json, "volume_ml") - q.volume * 1e6) <= 1e-6 * q.volume * 1e6;
}

/// What quality.json says of a region; null where it doesn't.
Json entry_of(const Json& json, std::int32_t region) {
  const auto regions = json.is_object() ? json.find("regions") : json.end();
  if (json.is_object() && regions != json.end() && regions->is_array())
    for (const Json& entry : *regions)
      if (number_in(entry, "label") == region) return entry;
  return {};
}

double three_digits(double value) {
  const double step = std::pow(10, std::floor(std::log10(value)) - 2);
  return std::round(value / step) * step;
}

void check_volume(const Json& entry, const std::string& name, const std::string& file, double ml, Findings& findings) {
  constexpr double most = 0.05;  // of the voxels' volume
  const double voxels = number_in(entry, "voxel_volume_ml");
  if (!(voxels > 0)) {
    findings.error(file, "has no voxel_volume_ml of the " + name, restore);
    return;
  }
  const double error = ml / voxels - 1;
  if (!(std::abs(error) > most)) return;
  findings.warning(file,
                   "the " + name + " has " + short_number(std::round(std::abs(error) * 1e3) / 10) + " % " +
                       (error < 0 ? "less" : "more") + " volume in the mesh than in the voxels (" +
                       short_number(three_digits(ml)) + " against " + short_number(three_digits(voxels)) + " mL)",
                   "make it again with more --tets");
}

void check_quality(const fs::path& path, const std::string& file, const TetMesh& mesh, Findings& findings) {
  const Json json = read_json(path, json_limit);
  const auto whole = json.is_object() ? json.find("mesh") : json.end();
  bool same = json.is_object() && whole != json.end() && describes(*whole, quality(mesh));
  std::vector<std::tuple<std::int32_t, Json, double>> regions;
  for (const std::int32_t region : std::set(mesh.regions.begin(), mesh.regions.end())) {
    const Quality q = quality(mesh, region);
    regions.emplace_back(region, entry_of(json, region), q.volume * 1e6);
    same = same && describes(std::get<Json>(regions.back()), q);
  }
  if (!same) {
    findings.error(brief(file), "describes another mesh (vertices, tetrahedra or volume differ)", restore);
    return;
  }
  for (const auto& [region, entry, ml] : regions) check_volume(entry, region_text(region), brief(file), ml, findings);
}

// ---- model.toml ----

/// The materials and fixed vertices of a model.toml, as far as numbers and names say them.
struct ModelText {
  std::map<Structure, TissueMaterial> materials;
  std::set<std::int64_t> fixed;
  bool only_vertices = true;  ///< no boxes and regions among the supports
};

bool applies(const toml::value& region, Structure s) {
  if (region.is_integer()) return region.as_integer() == label_of(s);
  if (!region.is_string()) return false;
  const std::string& text = region.as_string().str;
  return text == "*" || text == name_of(s) || text == std::to_string(label_of(s));
}

ModelText read_model(const fs::path& path, const Patient& patient) {
  const TomlFile toml(path, std::uint64_t{16} << 20);
  ModelText model;
  for (const toml::value& table : toml.tables("material"))
    for (const auto& [s, material] : patient.materials) {
      if (!applies(toml.need(table, "region", "\"*\""), s)) continue;
      TissueMaterial& found = model.materials[s];
      found.young = toml.number(toml.need(table, "young", "1.0e6"), "young");
      found.poisson = toml.number(toml.need(table, "poisson", "0.45"), "poisson");
      const toml::value* density = TomlFile::find(table, "density");
      found.density = density == nullptr ? 1000 : toml.number(*density, "density");
    }
  for (const toml::value& table : toml.tables("fixed")) {
    const toml::value* list = TomlFile::find(table, "vertices");
    model.only_vertices = model.only_vertices && list != nullptr;
    if (list == nullptr) continue;
    for (const toml::value& entry : toml.array(*list, "vertices")) model.fixed.insert(toml.whole(entry, "a vertex"));
  }
  return model;
}

}  // namespace

void check_model(const fs::path& path, const std::string& file_name, const Patient& patient, Findings& findings) {
  const ModelText model = read_model(path, patient);
  const std::string file = brief(file_name);
  const std::string to_do = "calot precompute uses " + file + ", the trainer patient.toml: write the same in both";
  for (const auto& entry : patient.materials) {
    const Structure s = entry.first;
    const TissueMaterial& wanted = entry.second;
    const auto found = model.materials.find(s);
    if (found == model.materials.end()) {
      findings.warning(file, "has no material for the " + std::string(name_of(s)), to_do);
      continue;
    }
    const auto differs = [&](const char* key, double a, double b, const char* unit) {
      if (std::abs(a - b) <= 1e-9 * std::abs(b)) return;
      findings.warning(file,
                       std::string(key) + " of the " + std::string(name_of(s)) + " is " + short_number(a) + unit +
                           " here and " + short_number(b) + unit + " in patient.toml",
                       to_do);
    };
    differs("young", found->second.young, wanted.young, " Pa");
    differs("poisson", found->second.poisson, wanted.poisson, "");
    differs("density", found->second.density, wanted.density, " kg/m3");
  }
  std::set<std::int64_t> fixed;
  for (const Attachment& attachment : patient.attachments)
    if (attachment.kind == AttachmentKind::fixed)
      for (const VertexId v : attachment.vertices) fixed.insert(v.value);
  if (model.only_vertices && model.fixed != fixed)
    findings.warning(file, "holds other vertices than the attachments of kind \"fixed\" in patient.toml", to_do);
}

}  // namespace detail

std::vector<Finding> check_patient(const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw InputError(folder.string(), "there is no such folder", "name a folder that calot patient wrote");
  detail::Findings findings;
  const auto guarded = [&](const auto& work) {
    try {
      work();
    } catch (const Error& error) {
      findings.list.push_back(detail::finding_of(error, folder));
    }
  };
  guarded([&] {
    detail::PatientReader reader(folder);
    const detail::PatientFiles files = reader.read_files();
    detail::FileCheck file_check(folder, files, reader.problems().empty(), findings);
    file_check.check();
    const bool readable =
        file_check.good(files.mesh) && (files.centrelines.empty() || fs::exists(folder / files.centrelines, code));
    const Patient patient = readable ? reader.read() : Patient();
    for (const InputError& problem : reader.problems()) findings.list.push_back(detail::finding_of(problem, folder));
    if (!readable || !reader.problems().empty()) return;
    for (const auto& [s, material] : patient.materials)
      if (!files.surfaces.contains(s))
        findings.error("patient.toml, region \"" + std::string(name_of(s)) + "\"", "has no surface to draw",
                       "add surface = \"surfaces/NAME.ply\", or make the folder anew with calot patient");
    detail::check_mesh(patient, detail::brief(files.mesh), findings);
    for (const auto& surface : files.surfaces)
      if (file_check.good(surface.second))
        guarded([&] { detail::check_surface(folder, surface.second, surface.first, patient.mesh, findings); });
    if (file_check.good(files.quality))
      guarded([&] { detail::check_quality(folder / files.quality, files.quality, patient.mesh, findings); });
    detail::check_materials(patient, findings);
    detail::check_attachments(patient, findings);
    detail::check_landmarks(patient, findings);
    if (file_check.good(files.model))
      guarded([&] { detail::check_model(folder / files.model, files.model, patient, findings); });
  });
  for (Finding& finding : findings.list)
    for (std::string* text : {&finding.where, &finding.what, &finding.what_to_do})
      *text = detail::one_line(std::move(*text));
  return findings.list;
}

}  // namespace calot
