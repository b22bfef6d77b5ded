// patient.toml with anything in it, beside a sound mesh: a patient that can be written again, or an InputError; and
// whatever it says, findings and no exception from the check.
#include <cstddef>
#include <cstdint>

#include "calot/base/error.h"
#include "fuzz/tiny_patient.h"
#include "tests/support/files.h"

namespace {

const calot::test::TempFolder& folder_with_files() {
  static const calot::test::TempFolder folder;
  static const bool written = [] {
    calot::fuzz::write_tiny_files(folder.path());
    return true;
  }();
  (void)written;
  return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto& folder = folder_with_files();
  calot::test::write_bytes(folder / "patient.toml", {reinterpret_cast<const char*>(data), size});
  (void)calot::check_patient(folder.path());
  calot::Patient patient;
  try {
    patient = calot::load_patient(folder.path());
  } catch (const calot::InputError&) {
    return 0;
  }
  std::ostringstream out;
  calot::detail::write_patient_toml(out, patient, "calot");
  calot::test::write_bytes(folder / "patient.toml", out.str());
  // Throws, and so fails, if what was read can't be written.
  (void)calot::load_patient(folder.path());
  return 0;
}
