#include "app/full_matrix.h"

#include <cmath>

#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/compliance/compliance_file.h"

namespace calot {

FullCompliance load_whole_matrix(const std::filesystem::path& path, const Model& model) {
  if (read_compliance_info(path, model).backend == Backend::dense)
    return load_full_compliance(path, model, &terminal_progress());
  return load_compliance(path, model, &terminal_progress()).full();
}

double probe_residual(const FullCompliance& compliance, const Model& model) {
  std::vector<std::uint8_t> free_vertex(compliance.vertices, 0);
  for (const Tet& tet : model.mesh().tets)
    for (const VertexId v : tet) free_vertex[v.index()] = model.is_fixed(v) ? 0 : 1;
  std::vector<double> z(compliance.size(), 0.0), x(compliance.size()), y(compliance.size());
  std::uint64_t state = 1;
  for (std::size_t r = 0; r < z.size(); ++r) {
    state = state * 6364136223846793005u + 1442695040888963407u;  // [Knuth1997] MMIX
    if (free_vertex[r / 3] != 0) z[r] = static_cast<double>(state >> 11) * 0x1.0p-52 - 1;
  }
  parallel_for(compliance.size(), [&](std::size_t r) {
    double sum = 0;
    for (std::size_t c = 0; c < z.size(); ++c) sum += compliance.row(r)[c] * z[c];
    x[r] = sum;
  });
  model.step_stiffness().multiply(x, y);
  double error = 0, size = 0;
  for (std::size_t r = 0; r < z.size(); ++r) {
    if (free_vertex[r / 3] == 0) continue;
    error += (y[r] - z[r]) * (y[r] - z[r]);
    size += z[r] * z[r];
  }
  return size > 0 ? std::sqrt(error / size) : 0;
}

}  // namespace calot
