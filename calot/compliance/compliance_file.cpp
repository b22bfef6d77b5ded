#include "calot/compliance/compliance_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <vector>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/memory.h"
#include "calot/compliance/hdf5_file.h"
#include "calot/compliance/sparse_factor.h"

namespace calot {
namespace {

using detail::H5Reader;
using detail::H5Writer;

constexpr const char* matrix_path = "/compliance";
constexpr const char* ids_path = "/node_ids";
constexpr const char* factor_path = "/factor";
constexpr std::uint64_t value_columns = 1024,
                        value_rows = 512;  // how the factor's values lie in the file: 4 MB a chunk
constexpr const char* compute_again = "compute it again with `calot precompute`";
constexpr std::size_t block_bytes = std::size_t{4} << 20;  // of rows handed to HDF5 at once: a chunk

/// The vertices that tets use, ascending: the blocks of the matrix in the file.
std::vector<std::uint32_t> used_vertices(const TetMesh& mesh) {
  std::vector<std::uint8_t> used(mesh.vertex_count(), 0);
  for (const Tet& tet : mesh.tets)
    for (const VertexId v : tet) used[v.index()] = 1;
  std::vector<std::uint32_t> ids;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) ids.push_back(static_cast<std::uint32_t>(v));
  return ids;
}

/// Vertices whose rows make one chunk.
std::size_t vertices_a_block(std::size_t blocks) {
  return std::clamp<std::size_t>(block_bytes / (9 * std::max<std::size_t>(blocks, 1) * sizeof(double)), 1,
                                 std::max<std::size_t>(blocks, 1));
}

const char* kind_of(const Dynamics& dynamics) {
  return dynamics.is_static() ? "static" : "dynamic";
}

void write_head(H5Writer& file, const Model& model, const std::vector<std::uint32_t>& ids, bool approximate) {
  file.vector(ids_path, ids);
  file.attribute("units", "m/N");
  file.attribute("kind", kind_of(model.dynamics()));
  file.attribute("time_step", model.dynamics().time_step);
  file.attribute("rayleigh_mass", model.dynamics().rayleigh_mass);
  file.attribute("rayleigh_stiffness", model.dynamics().rayleigh_stiffness);
  file.attribute("mesh_sha256", model.origin().mesh_sha256);
  file.attribute("model_sha256", model.fingerprint());
  file.attribute("calot_version", CALOT_VERSION);
  file.attribute("approximate", std::uint8_t{approximate});
}

/// Three rows a vertex for `count` vertices from `first`, 3·(mesh vertices) values a row.
using RowSource = std::function<void(VertexId first, std::size_t count, double* rows)>;

/// Strikes the columns of unused vertices from rows of 3·`vertices` values, in place.
void keep_columns(double* rows, std::size_t count, std::size_t vertices, const std::vector<std::uint32_t>& ids) {
  if (ids.size() == vertices) return;
  double* target = rows;
  for (std::size_t r = 0; r < count; ++r)
    for (const std::uint32_t v : ids) target = std::copy_n(rows + 3 * (r * vertices + v), 3, target);
}

/// The inverse: spreads rows of 3·|ids| values to 3·`vertices`, zeros elsewhere, in place from behind.
void spread_columns(double* rows, std::size_t count, std::size_t vertices, const std::vector<std::uint32_t>& ids) {
  if (ids.size() == vertices) return;
  for (std::size_t r = count; r-- > 0;) {
    const double* source = rows + 3 * r * ids.size();
    std::vector<double> row(3 * vertices, 0.0);
    for (std::size_t k = 0; k < ids.size(); ++k) std::copy_n(source + 3 * k, 3, row.data() + 3 * ids[k]);
    std::copy(row.begin(), row.end(), rows + 3 * r * vertices);
  }
}

/// How many of the ids from position k on follow each other without a gap, at most `limit`.
std::size_t run_length(const std::vector<std::uint32_t>& ids, std::size_t k, std::size_t limit) {
  std::size_t length = 1;
  while (length < limit && k + length < ids.size() && ids[k + length] == ids[k] + length) ++length;
  return length;
}

void write_rows(const std::filesystem::path& path, const Model& model, const RowSource& source, bool float32,
                bool approximate, Progress* progress) {
  if (progress != nullptr) progress->phase("write " + path.filename().string());
  const std::size_t vertices = model.mesh().vertex_count();
  const std::vector<std::uint32_t> ids = used_vertices(model.mesh());
  const std::size_t block = vertices_a_block(ids.size());
  PartialFile partial(path);
  H5Writer file(partial.path(), path.string());
  write_head(file, model, ids, approximate);
  file.matrix(matrix_path, 3 * ids.size(), 3 * ids.size(), 3 * block, float32);
  file.attribute_of(matrix_path, "units", "m/N");
  std::vector<double> rows(9 * block * vertices);
  for (std::size_t k = 0; k < ids.size(); k += block) {
    const std::size_t count = std::min(block, ids.size() - k);
    for (std::size_t done = 0; done < count;) {
      const std::size_t run = run_length(ids, k + done, count - done);
      source(VertexId(ids[k + done]), run, rows.data() + 9 * done * vertices);
      done += run;
    }
    keep_columns(rows.data(), 3 * count, vertices, ids);
    file.write_rows(3 * k, 3 * count, rows.data());
    if (progress != nullptr) progress->at(static_cast<double>(k + count) / static_cast<double>(ids.size()));
  }
  file.close();
  partial.commit();
}

// ---- the sparse factor ----

void write_factor(const std::filesystem::path& path, const Compliance& compliance, const Model& model,
                  Progress* progress) {
  if (progress != nullptr) progress->phase("write " + path.filename().string());
  const SparseFactor& factor = *compliance.factor();
  const FactorPattern& pattern = factor.pattern();
  const std::vector<VertexId> vertices = compliance.factor_vertices();
  std::vector<std::uint32_t> ordering;
  for (const std::uint32_t active : pattern.perm) {
    if (!vertices[active].valid())
      throw InputError("compliance", "its factor still has rows of vertices that are gone",
                       "call refresh() before saving");
    ordering.push_back(vertices[active].value);
  }
  PartialFile partial(path);
  H5Writer file(partial.path(), path.string());
  write_head(file, model, used_vertices(model.mesh()), false);
  file.group(factor_path);
  file.vector("/factor/ordering", ordering);
  file.vector("/factor/supernode_start", pattern.super_start);
  file.vector("/factor/row_start", std::vector<std::int64_t>(pattern.row_start.begin(), pattern.row_start.end()));
  file.vector("/factor/rows", pattern.rows);
  const std::uint64_t count = pattern.panel_start.back(), rows = (count + value_columns - 1) / value_columns;
  file.matrix("/factor/values", rows, value_columns, std::min(rows, value_rows), false);
  std::vector<double> block(value_rows * value_columns);
  for (std::uint64_t row = 0; row < rows; row += value_rows) {
    const std::uint64_t first = row * value_columns, here = std::min<std::uint64_t>(block.size(), count - first);
    std::fill(std::copy_n(factor.panel(0) + first, here, block.begin()), block.end(), 0.0);
    file.write_rows(row, std::min<std::uint64_t>(value_rows, rows - row), block.data());
    if (progress != nullptr) progress->at(static_cast<double>(first + here) / static_cast<double>(count));
  }
  file.close();
  partial.commit();
}

/// The pattern of the factor, with vertices as the model numbers them.
FactorPattern read_pattern(const H5Reader& file, const Model& model) {
  const std::uint64_t n = model.mesh().vertex_count(), most_rows = n * n;
  // Active vertices are the free ones that tets use, ascending.
  std::vector<std::uint32_t> active(n, ~0u);
  std::uint32_t free = 0;
  for (const std::uint32_t v : used_vertices(model.mesh()))
    if (!model.is_fixed(VertexId(v))) active[v] = free++;
  std::vector<std::uint32_t> perm = file.vector<std::uint32_t>("/factor/ordering", n);
  for (std::uint32_t& v : perm) {
    if (v >= n || active[v] == ~0u) file.refuse("its ordering names a vertex that is not free", compute_again);
    v = active[v];
  }
  if (perm.size() != free) file.refuse("its ordering leaves out free vertices", compute_again);
  const std::vector<std::int64_t> starts = file.vector<std::int64_t>("/factor/row_start", n + 1);
  std::vector<std::uint32_t> supernodes = file.vector<std::uint32_t>("/factor/supernode_start", n + 1);
  std::vector<std::uint32_t> rows = file.vector<std::uint32_t>("/factor/rows", most_rows);
  try {
    return complete_pattern(std::move(perm), std::move(supernodes), {starts.begin(), starts.end()}, std::move(rows));
  } catch (const InputError& wrong) {
    file.refuse(wrong.what(), "");
  }
}

Compliance read_factor(H5Reader& file, const Model& model, Progress* progress) {
  auto pattern = std::make_shared<FactorPattern>(read_pattern(file, model));
  const std::uint64_t count = pattern->panel_start.back(), rows = (count + value_columns - 1) / value_columns;
  const H5Reader::Shape shape = file.open_matrix("/factor/values");
  if (shape.rows != rows || shape.columns != value_columns)
    file.refuse("its factor has another number of values than its rows need", compute_again);
  require_memory(rows * value_columns * sizeof(double), "the factor");
  Buffer values(rows * value_columns);
  for (std::uint64_t row = 0; row < rows; row += value_rows) {
    const std::uint64_t here = std::min<std::uint64_t>(value_rows, rows - row);
    double* target = values.data() + row * value_columns;
    file.read_rows(row, here, target);
    if (!std::all_of(target, target + here * value_columns, [](double value) { return std::isfinite(value); }))
      file.refuse("its factor holds entries that are not finite", compute_again);
    if (progress != nullptr) progress->at(static_cast<double>(row + here) / static_cast<double>(rows));
  }
  return Compliance::from_factor(model, SparseFactor(std::move(pattern), std::move(values)));
}

// ---- reading ----

/// {major, minor} of "1.2.3".
std::optional<std::pair<int, int>> parse_version(const std::string& text) {
  std::pair<int, int> version;
  const char* end = text.data() + text.size();
  const auto major = std::from_chars(text.data(), end, version.first);
  if (major.ec != std::errc() || major.ptr == end || *major.ptr != '.') return {};
  const auto minor = std::from_chars(major.ptr + 1, end, version.second);
  return minor.ec == std::errc() ? std::optional(version) : std::nullopt;
}

void check_version(const H5Reader& file, const std::string& version) {
  const auto theirs = parse_version(version), ours = parse_version(CALOT_VERSION);
  if (!theirs) file.refuse("has no calot_version", compute_again);
  if (*theirs > *ours)
    file.refuse("was written by calot " + version + ", which is newer than this one (" CALOT_VERSION ")",
                "use that version or compute it again");
}

void check_number(const H5Reader& file, const char* key, double of_model) {
  const std::optional<double> found = file.number_attribute(key);
  if (!found) file.refuse(std::string("has no attribute ") + key, compute_again);
  if (*found == of_model) return;
  const auto text = [](double value) {
    char buffer[40];
    return std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
  };
  file.refuse(std::string("was computed for ") + key + " = " + text(*found) + ", but the model has " + text(of_model),
              compute_again);
}

/// A file from elsewhere need not carry model_sha256; then mesh, step and damping must agree.
void check_model(const H5Reader& file, const Model& model) {
  const std::string mesh = file.text_attribute("mesh_sha256").value_or("");
  const bool same_mesh = !mesh.empty() && mesh == model.origin().mesh_sha256;
  const std::optional<std::string> fingerprint = file.text_attribute("model_sha256");
  if (fingerprint && *fingerprint == model.fingerprint()) return;
  if (!same_mesh && !(fingerprint && mesh.empty() && model.origin().mesh_sha256.empty()))
    file.refuse("belongs to another mesh than " +
                    (model.origin().mesh_file.empty() ? "this model's" : model.origin().mesh_file.string()),
                "name the model it was computed for, or " + std::string(compute_again));
  const std::string kind = file.text_attribute("kind").value_or("");
  if (kind != kind_of(model.dynamics()))
    file.refuse("is of kind \"" + kind + "\", but the model is " + kind_of(model.dynamics()), compute_again);
  check_number(file, "time_step", model.dynamics().time_step);
  check_number(file, "rayleigh_mass", model.dynamics().rayleigh_mass);
  check_number(file, "rayleigh_stiffness", model.dynamics().rayleigh_stiffness);
  if (fingerprint) file.refuse("was computed with other materials, supports or masses than the model's", compute_again);
}

/// Checks version, model and node_ids.
ComplianceFileInfo check_identity(const H5Reader& file, const Model& model, const std::vector<std::uint32_t>& ids) {
  ComplianceFileInfo info;
  info.calot_version = file.text_attribute("calot_version").value_or("");
  check_version(file, info.calot_version);
  check_model(file, model);
  if (file.vector<std::uint32_t>(ids_path, model.mesh().vertex_count()) != ids)
    file.refuse("its node_ids don't number the vertices of the model's mesh", compute_again);
  info.approximate = file.number_attribute("approximate").value_or(0) != 0;
  info.backend = file.has(factor_path) ? Backend::sparse : Backend::dense;
  return info;
}

/// Checks everything but the entries.
ComplianceFileInfo check_head(H5Reader& file, const Model& model, const std::vector<std::uint32_t>& ids) {
  ComplianceFileInfo info = check_identity(file, model, ids);
  if (info.backend == Backend::sparse)
    file.refuse("holds a sparse factor, not the whole matrix", "compute it again with --backend dense");
  const H5Reader::Shape shape = file.open_matrix(matrix_path);
  info.float32 = shape.float32;
  if (shape.rows != 3 * ids.size() || shape.columns != 3 * ids.size())
    file.refuse("its matrix is " + std::to_string(shape.rows) + " × " + std::to_string(shape.columns) + ", but " +
                    std::to_string(ids.size()) + " vertices need " + std::to_string(3 * ids.size()) +
                    " rows and columns",
                compute_again);
  return info;
}

/// Reads the rows of one run of used vertices and spreads them over all columns.
void read_run(const H5Reader& file, std::size_t position, std::size_t count, std::size_t vertices,
              const std::vector<std::uint32_t>& ids, double* rows) {
  file.read_rows(3 * position, 3 * count, rows);
  const std::size_t values = 9 * count * ids.size();
  if (!std::all_of(rows, rows + values, [](double value) { return std::isfinite(value); }))
    file.refuse("holds entries that are not finite, between rows " + std::to_string(3 * position) + " and " +
                    std::to_string(3 * (position + count) - 1),
                compute_again);
  spread_columns(rows, 3 * count, vertices, ids);
}

/// A source of rows over all vertices of the mesh; zeros where no tet uses a vertex.
RowSource rows_of(const H5Reader& file, const std::vector<std::uint32_t>& ids, std::size_t vertices,
                  Progress* progress) {
  return [&file, &ids, vertices, progress](VertexId first, std::size_t count, double* rows) {
    const std::size_t end = first.index() + count;
    for (std::size_t v = first.index(); v < end;) {
      double* target = rows + 9 * (v - first.index()) * vertices;
      const auto found = std::lower_bound(ids.begin(), ids.end(), static_cast<std::uint32_t>(v));
      const auto position = static_cast<std::size_t>(found - ids.begin());
      if (found == ids.end() || *found != v) {
        std::fill_n(target, 9 * vertices, 0.0);
        ++v;
        continue;
      }
      const std::size_t run = run_length(ids, position, std::min(end - v, vertices_a_block(ids.size())));
      read_run(file, position, run, vertices, ids, target);
      v += run;
      if (progress != nullptr) progress->at(static_cast<double>(v) / static_cast<double>(vertices));
    }
  };
}

}  // namespace

void save_compliance(const std::filesystem::path& path, const Compliance& compliance, const Model& model, bool float32,
                     Progress* progress) {
  if (compliance.pending_rank() != 0)
    throw InputError("compliance", "has corrections that wait to be folded in", "call fold() before saving");
  if (compliance.factor() != nullptr) {
    if (float32) throw InputError("compliance", "a sparse factor is written in 64 bits", "leave out float32");
    return write_factor(path, compliance, model, progress);
  }
  const RowSource source = [&](VertexId first, std::size_t count, double* rows) {
    compliance.copy_rows(first, count, rows);
  };
  write_rows(path, model, source, float32, false, progress);
}

void save_full_compliance(const std::filesystem::path& path, const FullCompliance& compliance, const Model& model,
                          bool float32, Progress* progress, bool approximate) {
  if (compliance.vertices != model.mesh().vertex_count())
    throw InputError("compliance", "has another number of vertices than the model", "give the model it belongs to");
  const RowSource source = [&](VertexId first, std::size_t count, double* rows) {
    std::copy_n(compliance.row(3 * first.index()), 3 * count * compliance.size(), rows);
  };
  write_rows(path, model, source, float32, approximate, progress);
}

ComplianceFileInfo read_compliance_info(const std::filesystem::path& path, const Model& model) {
  H5Reader file(path);
  const std::vector<std::uint32_t> ids = used_vertices(model.mesh());
  const ComplianceFileInfo info = check_identity(file, model, ids);
  return info.backend == Backend::sparse ? info : check_head(file, model, ids);
}

Compliance load_compliance(const std::filesystem::path& path, const Model& model, Progress* progress) {
  const std::vector<std::uint32_t> ids = used_vertices(model.mesh());
  H5Reader file(path);
  if (progress != nullptr) progress->phase("read " + path.filename().string());
  if (check_identity(file, model, ids).backend == Backend::sparse) return read_factor(file, model, progress);
  if (check_head(file, model, ids).approximate)
    file.refuse("holds the paper's approximate update, which is not the inverse of the cut model", compute_again);
  if (progress != nullptr) progress->phase("read " + path.filename().string());
  return Compliance::from_rows(model, rows_of(file, ids, model.mesh().vertex_count(), progress));
}

FullCompliance load_full_compliance(const std::filesystem::path& path, const Model& model, Progress* progress) {
  const std::vector<std::uint32_t> ids = used_vertices(model.mesh());
  const std::size_t vertices = model.mesh().vertex_count();
  H5Reader file(path);
  check_head(file, model, ids);
  require_memory(9 * sizeof(double) * vertices * vertices, "the compliance in " + path.string());
  if (progress != nullptr) progress->phase("read " + path.filename().string());
  FullCompliance compliance{vertices, std::vector<double>(9 * vertices * vertices)};
  rows_of(file, ids, vertices, progress)(VertexId(0), vertices, compliance.values.data());
  return compliance;
}

}  // namespace calot
