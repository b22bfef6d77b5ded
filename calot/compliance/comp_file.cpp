// SOFA's PrecomputedConstraintCorrection files.
#include <cmath>
#include <fstream>
#include <vector>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/memory.h"
#include "calot/compliance/compliance_file.h"

namespace calot {
namespace {

void check_step(const std::filesystem::path& path, double time_step) {
  if (!(time_step > 0) || !std::isfinite(time_step))
    throw InputError(path.string(), "a .comp file holds C/h, and a static model has no step h", "use .h5");
}

}  // namespace

void write_comp(const std::filesystem::path& path, const FullCompliance& compliance, double time_step) {
  check_step(path, time_step);
  std::vector<double> row(compliance.size());
  write_file(path, [&](std::ostream& out) {
    for (std::size_t r = 0; r < compliance.size(); ++r) {
      for (std::size_t c = 0; c < row.size(); ++c) row[c] = compliance.row(r)[c] / time_step;
      out.write(reinterpret_cast<const char*>(row.data()), static_cast<std::streamsize>(row.size() * sizeof(double)));
    }
  });
}

FullCompliance read_comp(const std::filesystem::path& path, std::size_t vertices, double time_step) {
  check_step(path, time_step);
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) throw InputError(path.string(), "no such file", "check the name");
  const std::uint64_t needed = std::uint64_t{9} * vertices * vertices * sizeof(double);
  const std::uint64_t found = std::filesystem::file_size(path);
  if (found != needed)
    throw InputError(path.string(),
                     "holds " + std::to_string(found) + " bytes, but a mesh of " + std::to_string(vertices) +
                         " vertices needs " + std::to_string(needed),
                     "give the model that it was computed for");
  require_memory(needed, "the compliance in " + path.string());
  FullCompliance compliance{vertices, std::vector<double>(9 * vertices * vertices)};
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(compliance.values.data()), static_cast<std::streamsize>(needed));
  if (!in) throw InputError(path.string(), "can't be read", "check the disk");
  for (std::size_t i = 0; i < compliance.values.size(); ++i) {
    double& value = compliance.values[i];
    if (!std::isfinite(value))
      throw InputError(path.string(), "entry " + std::to_string(i) + " is not a finite number", "compute it again");
    value *= time_step;
  }
  return compliance;
}

}  // namespace calot
