#include "calot/base/error.h"

namespace calot {
namespace {
std::string join(const std::string& where, const std::string& what, const std::string& what_to_do) {
  std::string line = where.empty() ? what : where + ": " + what;
  if (!what_to_do.empty()) line += "; " + what_to_do;
  return line;
}
}  // namespace

Error::Error(ErrorKind kind, const std::string& where, const std::string& what, const std::string& what_to_do)
    : std::runtime_error(join(where, what, what_to_do)), kind_(kind) {}

std::string at_line(const std::string& file, std::size_t line) {
  return line == 0 ? file : file + ":" + std::to_string(line);
}

}  // namespace calot
