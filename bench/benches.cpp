#include "bench/bench.h"

namespace calot::bench {

// Each is defined in bench_NAME.cpp.

const std::vector<Bench>& benches() {
  static const std::vector<Bench> all = {};
  return all;
}

}  // namespace calot::bench
