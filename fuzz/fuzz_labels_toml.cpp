// labels.toml with anything in it: options that write and read back equal, or an InputError.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>

#include "calot/base/error.h"
#include "calot/patient/import_options.h"
#include "tests/support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const calot::test::TempFolder folder;
  const auto path = folder / "labels.toml";
  calot::test::write_bytes(path, {reinterpret_cast<const char*>(data), size});
  calot::ImportOptions options;
  try {
    options = calot::read_import_options(path);
  } catch (const calot::InputError&) {
    return 0;
  }
  std::ostringstream out;
  calot::write_import_options(out, options);
  calot::test::write_bytes(path, out.str());
  // Throws, and so fails, if what was read can't be written.
  const calot::ImportOptions again = calot::read_import_options(path);
  if (again.table.names != options.table.names || again.table.numbers != options.table.numbers) std::abort();
  return 0;
}
