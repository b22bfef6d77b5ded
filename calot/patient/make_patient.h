// The whole way from files to a patient that can be operated on.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/patient/import_options.h"
#include "calot/patient/name_labels.h"
#include "calot/patient/patient.h"

namespace calot {

/// What a patient is made from, and how.
struct PatientRequest {
  std::filesystem::path ct, labels;
  std::vector<std::filesystem::path> centrelines;  ///< of ducts and arteries; may be empty
  std::filesystem::path table;                     ///< labels.toml; empty: the defaults
  std::string name;                                ///< of the patient
  std::string series;                              ///< DICOM series, where there are several
  OverlapRule overlaps = OverlapRule::refuse;
  bool resample_labels = false;
  double surface_unit = 1e-3;  ///< metres per unit of surfaces given as labels
  std::size_t tets = 20000;    ///< at most
};

/// Where the steps say what they found and did; one line each.
struct PatientLog {
  std::function<void(const std::string&)> say = [](const std::string&) {};
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};

struct MadePatient {
  Patient patient;
  LabelMesh meshed;
  CompletedAnatomy anatomy;
  Provenance provenance;
};

/// Reads CT, labels and centrelines, names the labels, completes the anatomy, meshes it, and finds what holds it and
/// where to operate. Throws what those steps throw (image/, name_labels.h, completion.h, mesher.h, attachments.h,
/// landmarks.h).
MadePatient make_patient(const PatientRequest& request, const PatientLog& log, Progress& progress);

}  // namespace calot
