// Inside this room only: patient.toml and model.toml of a patient's folder.
#pragma once
#include <iosfwd>
#include <map>

#include "calot/base/error.h"
#include "calot/base/toml_file.h"
#include "calot/patient/patient.h"

namespace calot::detail {

/// "liver", "common_bile_duct".
std::string file_stem(Structure s);
/// "surfaces/liver.ply"
std::string surface_name(Structure s);

/// @param made_by  the program and its version
void write_patient_toml(std::ostream& out, const Patient& patient, const std::string& made_by);
void write_model_toml(std::ostream& out, const Patient& patient, const std::string& made_by);

/// The files that patient.toml names, relative to its folder.
struct PatientFiles {
  std::string mesh, centrelines, labels, model, quality, provenance;  ///< empty where not named
  std::map<Structure, std::string> surfaces;
};

/// Reads patient.toml step by step. A mistake within one entry doesn't hide those in others: they are collected.
class PatientReader {
 public:
  /// Parses the file. Throws InputError where it is no TOML.
  explicit PatientReader(const std::filesystem::path& folder);

  /// Header, files and regions; needs no other file.
  PatientFiles read_files();
  /// The rest, with mesh and centrelines; after read_files.
  Patient read();
  /// What was wrong, in the order found, 20 at most; the patient is whole only if this is empty.
  [[nodiscard]] const std::vector<InputError>& problems() const { return problems_; }

 private:
  template <class Work>
  void guarded(const Work& work);
  template <class Read>
  void each(const std::string& name, const Read& read);

  void read_header();
  std::string file_name(const toml::value& value, const std::string& key) const;
  void read_region(const toml::value& table);
  void check_regions();
  void read_attachment(const toml::value& table);
  void read_border_cut(const toml::value& table);
  void read_port(const toml::value& table);
  void read_camera(const toml::value& table);
  void read_triangle(const toml::value& table);
  void read_notes(const toml::value& table);
  TubeSite read_site(const toml::value& table) const;
  void complete_site(TubeSite& site, const toml::value& table) const;

  Vec3 need_point(const toml::value& table, const std::string& key) const;
  Vec3 place(const toml::value& value, const std::string& key) const;
  Vec3 direction(const toml::value& value, const std::string& key) const;
  double need_number(const toml::value& table, const std::string& key, double low, double high,
                     const std::string& unit) const;
  std::string need_text(const toml::value& table, const std::string& key, const std::string& example) const;
  Structure structure(const toml::value& value, const std::string& key) const;

  std::filesystem::path folder_;
  TomlFile toml_;
  Patient patient_;
  PatientFiles files_;
  std::map<Structure, std::size_t> region_lines_;
  std::map<Structure, Centreline> tubes_;  // towards the gallbladder
  std::vector<InputError> problems_;
};

}  // namespace calot::detail
