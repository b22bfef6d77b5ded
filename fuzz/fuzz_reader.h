// What all fuzzers of readers share: any bytes give a mesh or an InputError; anything else is a finding.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "calot/base/error.h"
#include "calot/mesh/raw_mesh.h"

namespace calot::fuzz {

template <class Parse>
int read_anything(const std::uint8_t* data, std::size_t size, const Parse& parse) {
  try {
    parse(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz", 1e-3);
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}

}  // namespace calot::fuzz
