// The surface readers against anything; the first byte chooses which.
#include "fuzz/fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  using namespace calot;
  switch (data[0] % 3) {
    case 0:
      return fuzz::read_anything(data + 1, size - 1, detail::parse_stl);
    case 1:
      return fuzz::read_anything(data + 1, size - 1, detail::parse_obj);
    default:
      return fuzz::read_anything(data + 1, size - 1, detail::parse_ply);
  }
}
