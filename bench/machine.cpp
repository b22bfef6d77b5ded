#include <sys/utsname.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "bench/bench.h"
#include "calot/base/parallel.h"
#include "calot/compliance/blas.h"

namespace calot::bench {
namespace {

/// What follows "key :" in the first such line of a file; empty if there is none.
std::string value_of(const char* file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const std::size_t value = line.find_first_not_of(" \t:=\"", key.size());
    return value == std::string::npos ? "" : line.substr(value, line.find_last_not_of(" \t\"") - value + 1);
  }
  return "";
}

std::string compiler_name() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "GCC " __VERSION__;
#endif
}

std::string system_name() {
  utsname name{};
  uname(&name);
  const std::string distribution = value_of("/etc/os-release", "PRETTY_NAME");
  return (distribution.empty() ? std::string(name.sysname) : distribution) + ", " + name.machine;
}

}  // namespace

Machine this_machine() {
  Machine machine;
  machine.processor = value_of("/proc/cpuinfo", "model name");
  machine.blas = blas::kernel_name();
  machine.compiler = compiler_name();
  machine.system = system_name();
  machine.cores = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  machine.threads = thread_count();
  machine.memory_gb = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE)) / 1e9;
  return machine;
}

}  // namespace calot::bench
