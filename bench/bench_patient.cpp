// The whole way from a full abdominal CT, 512 × 512 × 300 voxels, to a patient's folder.
#include <unistd.h>

#include <cstdio>

#include "bench/benchmarks.h"
#include "calot/base/memory.h"
#include "calot/image/ct_file.h"
#include "calot/patient/make_patient.h"
#include "calot/patient/phantom.h"

namespace calot::bench {
namespace {

namespace fs = std::filesystem;

/// Files of a phantom in a folder; what it took memory is given back before the measurement.
void write_inputs(const fs::path& folder, Progress& progress) {
  const Phantom phantom = make_phantom({.seed = 1, .matrix = {{512, 512, 300}}}, progress);
  write_ct(folder / "ct.nii.gz", phantom.ct);
  write_label_map(folder / "labels.nii.gz", phantom.labels);
  write_markups(folder / "ducts.mrk.json", phantom.lines);
}

}  // namespace

std::vector<Row> bench_patient(const BenchOptions& options) {
  Progress silent;
  Progress& progress = options.progress ? *options.progress : silent;
  const fs::path folder = fs::temp_directory_path() / ("calot-patient-" + std::to_string(::getpid()));
  fs::create_directories(folder / "patient");
  std::vector<Row> rows;
  try {
    const double making = seconds_of([&] { write_inputs(folder, progress); });
    const double memory_before = static_cast<double>(peak_memory());
    PatientRequest request;
    request.ct = folder / "ct.nii.gz";
    request.labels = folder / "labels.nii.gz";
    request.centrelines = {folder / "ducts.mrk.json"};
    request.name = "phantom 1";
    const double reading = seconds_of([&] {
      (void)read_ct(request.ct, progress);
      (void)read_label_map(request.labels);
    });
    const double seconds = seconds_of([&] {
      const MadePatient made = make_patient(request, {}, progress);
      write_patient(folder / "patient", made.patient, made.meshed, made.anatomy, made.provenance);
    });
    rows.push_back({.name = "patient.phantom_512", .value = making, .unit = "s"});
    rows.push_back({.name = "patient.512",
                    .value = seconds,
                    .unit = "s",
                    .baseline = "reading the CT and the labels alone",
                    .ratio = seconds / reading,
                    .goal = 180});
    rows.push_back({.name = "patient.512.memory",
                    .value = static_cast<double>(peak_memory()) / 1e9,
                    .unit = "GB",
                    .baseline = "peak while the phantom was made",
                    .ratio = static_cast<double>(peak_memory()) / memory_before,
                    .goal = 4});
  } catch (...) {
    fs::remove_all(folder);
    throw;
  }
  fs::remove_all(folder);
  return rows;
}

}  // namespace calot::bench
