// Compliance files: C.h5 (HDF5) and SOFA's .comp.
#pragma once
#include <filesystem>
#include <string>

#include "calot/compliance/compliance.h"

namespace calot {

/// Writes C.h5: `/compliance` (dense) or `/factor/…` (sparse), `/node_ids`, attributes `units`, `kind`, `time_step`,
/// `rayleigh_mass`, `rayleigh_stiffness`, `mesh_sha256`, `model_sha256`, `calot_version`; checksummed chunks.
void save_compliance(const std::filesystem::path& path, const Compliance& compliance, const Model& model, bool float32 = false,
                     Progress* progress = nullptr);
void save_full_compliance(const std::filesystem::path& path, const FullCompliance& compliance, const Model& model,
                          bool float32 = false, Progress* progress = nullptr);

/// Reads C.h5 of `model`. Throws InputError with the reason if the file belongs to another model, is truncated, fails a
/// checksum or was written by a newer version.
Compliance load_compliance(const std::filesystem::path& path, const Model& model, Progress* progress = nullptr);
FullCompliance load_full_compliance(const std::filesystem::path& path, const Model& model, Progress* progress = nullptr);

/// SOFA's PrecomputedConstraintCorrection file: C/h, raw row-major doubles, no header, all vertices. h > 0 only.
void write_comp(const std::filesystem::path& path, const FullCompliance& compliance, double time_step);
FullCompliance read_comp(const std::filesystem::path& path, std::size_t vertices, double time_step);

}  // namespace calot
