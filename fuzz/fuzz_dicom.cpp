// The structure of DICOM files: whatever the bytes, elements within them or nothing.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "calot/image/dicom_elements.h"

namespace {

/// A view that leaves the bytes would read what isn't there.
void check_inside(std::string_view part, std::string_view whole) {
  if (!part.empty() && (part.data() < whole.data() || part.data() + part.size() > whole.data() + whole.size()))
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const bool only_header : {false, true}) {
    const auto parsed = calot::parse_dicom(bytes, only_header);
    if (!parsed) continue;
    for (const auto& [tag, value] : parsed->elements) {
      check_inside(value, bytes);
      static_cast<void>(parsed->text(tag));
      static_cast<void>(parsed->numbers(tag));
      static_cast<void>(parsed->short_number(tag, 0));
    }
    check_inside(parsed->pixels, bytes);
    for (const std::string_view fragment : parsed->fragments) check_inside(fragment, bytes);
  }
  return 0;
}
