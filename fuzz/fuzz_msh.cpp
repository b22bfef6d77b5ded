// The .msh reader against anything.
#include "fuzz/fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return calot::fuzz::read_anything(data, size, calot::detail::parse_msh);
}
