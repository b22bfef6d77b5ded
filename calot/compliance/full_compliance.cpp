#include "calot/compliance/full_compliance.h"

#include <algorithm>
#include <cstring>

#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/mesh/parts.h"

namespace calot {

void paper_delete_vertices(FullCompliance& compliance, std::span<const VertexId> deleted) {
  if (deleted.empty()) return;
  if (deleted.back().index() >= compliance.vertices)
    throw InputError("deleted vertex " + std::to_string(deleted.back().value), "is not in the compliance");
  std::vector<std::uint8_t> gone(compliance.vertices, 0);
  for (const VertexId v : deleted) gone[v.index()] = 1;
  std::vector<std::pair<std::size_t, std::size_t>> runs;  // surviving vertices, first and count
  for (std::size_t v = 0; v < compliance.vertices; ++v) {
    if (gone[v]) continue;
    if (runs.empty() || runs.back().first + runs.back().second != v) runs.emplace_back(v, 0);
    ++runs.back().second;
  }
  // In place, from the front: what is written never passes what is still to be read.
  const std::size_t width = compliance.size();
  double* to = compliance.values.data();
  for (std::size_t v = 0; v < compliance.vertices; ++v) {
    if (gone[v]) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* from = compliance.values.data() + (3 * v + axis) * width;
      for (const auto& [first, count] : runs) {
        std::memmove(to, from + 3 * first, 3 * count * sizeof(double));
        to += 3 * count;
      }
    }
  }
  compliance.vertices -= deleted.size();
  compliance.values.resize(compliance.size() * compliance.size());
}

void paper_zero_between_parts(FullCompliance& compliance, std::span<const std::uint32_t> part) {
  if (part.size() != compliance.vertices)
    throw InputError("parts", "are given for " + std::to_string(part.size()) + " of " +
                                  std::to_string(compliance.vertices) + " vertices");
  parallel_blocks(compliance.vertices, 16, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double* row = compliance.row(3 * i + axis);
        for (std::size_t j = 0; j < compliance.vertices; ++j)
          if (part[i] != part[j]) row[3 * j] = row[3 * j + 1] = row[3 * j + 2] = 0;
      }
  });
}

void paper_update(FullCompliance& compliance, std::span<const VertexId> orphaned, const TetMesh& mesh) {
  paper_delete_vertices(compliance, orphaned);
  const Parts parts = face_connected_parts(mesh);
  std::vector<std::uint32_t> part(mesh.vertex_count(), 0);
  for (std::uint32_t p = static_cast<std::uint32_t>(parts.count()); p-- > 0;)
    for (const VertexId v : parts.vertices[p]) part[v.index()] = p;
  paper_zero_between_parts(compliance, part);
}

}  // namespace calot
