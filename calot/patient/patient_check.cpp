#include "calot/patient/patient_check.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "calot/base/files.h"
#include "calot/patient/json_file.h"

namespace calot {
namespace fs = std::filesystem;
namespace detail {
namespace {

constexpr std::uint64_t json_limit = std::uint64_t{16} << 20;
const std::string restore = "restore it, or make the folder anew with calot patient";

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
  FileCheck(const fs::path& folder, const PatientFiles& files, Findings& findings)
      : folder_(folder), files_(files), findings_(findings) {}

  void check() {
    for (const std::string* name :
         {&files_.mesh, &files_.centrelines, &files_.labels, &files_.model, &files_.quality, &files_.provenance})
      if (!name->empty()) check_there(*name);
    for (const auto& [s, name] : files_.surfaces) check_there(name);
    if (!files_.provenance.empty() && !bad_.contains(files_.provenance)) check_hashes();
  }

  /// False if a file is missing or not the one that was written.
  [[nodiscard]] bool good(const std::string& name) const { return !name.empty() && !bad_.contains(name); }

 private:
  void check_there(const std::string& name) {
    std::error_code code;
    if (bad_.contains(name) || fs::is_regular_file(folder_ / name, code)) return;
    findings_.error(name, "the file is missing", restore);
    bad_.insert(name);
  }

  void check_hashes() {
    try {
      const Json json = read_json(folder_ / files_.provenance, json_limit);
      const auto files = json.is_object() ? json.find("files") : json.end();
      if (!json.is_object() || files == json.end() || !files->is_object())
        throw InputError((folder_ / files_.provenance).string(), "has no \"files\" with hashes", restore);
      for (const auto& [name, hash] : files->items()) check_hash(name, hash);
      if (good(files_.mesh) && !files->contains(files_.mesh))
        findings_.warning(files_.mesh, "is not among the files of " + files_.provenance + ": it was exchanged",
                          "check that attachments and landmarks fit it");
    } catch (const Error& error) {
      findings_.list.push_back(finding_of(error, folder_));
      bad_.insert(files_.provenance);
    }
  }

  void check_hash(const std::string& name, const Json& hash) {
    const fs::path path(name);
    if (!path.is_relative() || std::find(path.begin(), path.end(), "..") != path.end()) {
      findings_.error(files_.provenance, brief(name) + " is not a file of this folder", restore);
      return;
    }
    check_there(name);
    if (bad_.contains(name) || hash == sha256_of_file(folder_ / name)) return;
    bad_.insert(name);
    const std::string changed =
        "was changed after the folder was made (its hash differs from " + files_.provenance + ")";
    if (name == files_.mesh)
      findings_.error(name, changed + "; attachments and landmarks no longer fit, and nothing else was checked",
                      restore);
    else if (name == files_.centrelines)
      findings_.warning(name, changed,
                        "if you meant to: calot patient draws the tubes anew, clips alone don't move them");
    else if (name == files_.labels || is_surface(name))
      findings_.error(name, changed + " and no longer fits the mesh", restore);
    else
      findings_.warning(name, changed, restore);
  }

  [[nodiscard]] bool is_surface(const std::string& name) const {
    return std::any_of(files_.surfaces.begin(), files_.surfaces.end(),
                       [&](const auto& surface) { return surface.second == name; });
  }

  const fs::path& folder_;
  const PatientFiles& files_;
  Findings& findings_;
  std::set<std::string> bad_;
};

void check_quality(const fs::path& path, const std::string& file, const TetMesh& mesh, Findings& findings) {
  const Json json = read_json(path, json_limit);
  const Quality q = quality(mesh);
  const auto number = [&](const char* key) {
    const auto whole = json.is_object() ? json.find("mesh") : json.end();
    if (!json.is_object() || whole == json.end() || !whole->is_object()) return std::nan("");
    const auto value = whole->find(key);
    return value != whole->end() && value->is_number() ? value->get<double>() : std::nan("");
  };
  const bool same = number("vertices") == static_cast<double>(q.vertices) &&
                    number("tets") == static_cast<double>(q.tets) &&
                    std::abs(number("volume_ml") - q.volume * 1e6) <= 1e-6 * q.volume * 1e6;
  if (!same) findings.error(file, "describes another mesh (vertices, tetrahedra or volume differ)", restore);
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

void check_model(const fs::path& path, const std::string& file, const Patient& patient, Findings& findings) {
  const ModelText model = read_model(path, patient);
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
    detail::FileCheck file_check(folder, files, findings);
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
    detail::check_mesh(patient, files.mesh, findings);
    if (file_check.good(files.quality))
      guarded([&] { detail::check_quality(folder / files.quality, files.quality, patient.mesh, findings); });
    detail::check_materials(patient, findings);
    detail::check_attachments(patient, findings);
    detail::check_landmarks(patient, findings);
    if (file_check.good(files.model))
      guarded([&] { detail::check_model(folder / files.model, files.model, patient, findings); });
  });
  return findings.list;
}

}  // namespace calot
