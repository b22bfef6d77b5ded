// NRRD headers with their segments: whatever the bytes, a header or an InputError.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "calot/base/error.h"
#include "calot/image/nrrd.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const calot::NrrdHeader header = calot::parse_nrrd_header(text, "fuzz");
    calot::nrrd_segments(header, "fuzz");
  } catch (const calot::InputError&) {
    return 0;
  }
  return 0;
}
