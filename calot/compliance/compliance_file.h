// Compliance files: C.h5 (HDF5) and SOFA's .comp.
#pragma once
#include <filesystem>
#include <string>

#include "calot/compliance/compliance.h"

namespace calot {

/// Writes C.h5: `/compliance` (dense) or `/factor/…` (sparse), `/node_ids`, attributes `units`, `kind`, `time_step`,
/// `rayleigh_mass`, `rayleigh_stiffness`, `mesh_sha256`, `model_sha256`, `calot_version`; checksummed chunks.
void save_compliance(const std::filesystem::path& path, const Compliance& compliance, const Model& model,
                     bool float32 = false, Progress* progress = nullptr);
/// The same for a full matrix over all vertices of the model's mesh.
/// @param approximate  true where it is not the inverse of the model's Â, as after the paper's update; the file says so
void save_full_compliance(const std::filesystem::path& path, const FullCompliance& compliance, const Model& model,
                          bool float32 = false, Progress* progress = nullptr, bool approximate = false);

/// What a C.h5 says about itself.
struct ComplianceFileInfo {
  std::string calot_version;  ///< that wrote it
  Backend backend = Backend::dense;
  bool float32 = false;      ///< entries have 7 digits only
  bool approximate = false;  ///< not an inverse: the paper's update
};
/// Reads the head of C.h5 and checks that it belongs to `model`, as `load_compliance` does.
ComplianceFileInfo read_compliance_info(const std::filesystem::path& path, const Model& model);

/// Reads C.h5 of `model`. Throws InputError with the reason if the file belongs to another model, is truncated, fails a
/// checksum, was written by a newer version, or (load_compliance) is approximate.
Compliance load_compliance(const std::filesystem::path& path, const Model& model, Progress* progress = nullptr);
FullCompliance load_full_compliance(const std::filesystem::path& path, const Model& model,
                                    Progress* progress = nullptr);

/// SOFA's PrecomputedConstraintCorrection file: C/h, raw row-major doubles, no header, all vertices. h > 0 only.
void write_comp(const std::filesystem::path& path, const FullCompliance& compliance, double time_step);
FullCompliance read_comp(const std::filesystem::path& path, std::size_t vertices, double time_step);

}  // namespace calot
