// The extensions of a NIfTI header: whatever the bytes, names or an InputError.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "calot/base/error.h"
#include "calot/image/nifti.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const bool swapped : {false, true}) {
    try {
      calot::label_names_in_extensions(bytes, swapped, "fuzz");
    } catch (const calot::InputError&) {
    }
  }
  return 0;
}
