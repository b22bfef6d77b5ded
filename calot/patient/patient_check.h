// Inside this room only: the parts of check_patient.
#pragma once
#include <vector>

#include "calot/patient/patient.h"
#include "calot/patient/patient_file.h"

namespace calot::detail {

/// Findings as they come, errors and warnings mixed in the order of the checks.
class Findings {
 public:
  void error(const std::string& where, const std::string& what, const std::string& what_to_do) {
    list.push_back({true, where, what, what_to_do});
  }
  void warning(const std::string& where, const std::string& what, const std::string& what_to_do) {
    list.push_back({false, where, what, what_to_do});
  }
  std::vector<Finding> list;
};

/// The mesh itself: the organs that the operation needs, one part a region, a closed outside, angles.
void check_mesh(const Patient& patient, const std::string& file, Findings& findings);
/// Numbers that are allowed but look like a slip of the unit.
void check_materials(const Patient& patient, Findings& findings);
/// Every part held, nothing held entirely, cut faces held.
void check_attachments(const Patient& patient, Findings& findings);
/// Ports, camera, triangle, clips and cuts.
void check_landmarks(const Patient& patient, Findings& findings);
/// model.toml against patient.toml.
void check_model(const std::filesystem::path& path, const std::string& file, const Patient& patient,
                 Findings& findings);

/// "liver", or "region 77"
std::string region_text(std::int32_t region);
/// "12.5 mm"
std::string mm_text(double metres);

}  // namespace calot::detail
