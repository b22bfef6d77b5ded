#include "calot/compliance/hdf5_file.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "calot/base/error.h"
#include "calot/base/memory.h"

namespace calot::detail {
namespace {

/// Before the first call: no messages of HDF5's own, and no clean-up at exit, which complains once a file could not be
/// closed on a full disk.
void start_hdf5() {
  static const bool started = [] {
    H5dont_atexit();
    H5open();
    return true;
  }();
  (void)started;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

H5Handle space_of(std::initializer_list<hsize_t> dimensions) {
  return {H5Screate_simple(static_cast<int>(dimensions.size()), std::data(dimensions), nullptr), H5Sclose};
}

H5Handle text_type() {
  H5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

/// How an object is made: without the time, so that the same content gives the same bytes.
H5Handle creation(hid_t kind) {
  H5Handle list(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(list.get(), false);
  return list;
}

/// Checksummed chunks; a matrix is read and written once, so chunks are not kept.
H5Handle chunked(std::initializer_list<hsize_t> chunk) {
  H5Handle list = creation(H5P_DATASET_CREATE);
  H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), std::data(chunk));
  H5Pset_fletcher32(list.get());
  return list;
}

H5Handle chunk_cache(std::size_t bytes) {
  H5Handle list(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(list.get(), 521, bytes, 1.0);
  return list;
}

/// The rows first … first + count of a matrix, selected in its file space; a default handle on failure.
H5Handle select_rows(const H5Handle& dataset, std::uint64_t first, std::uint64_t count, std::uint64_t columns) {
  H5Handle space(H5Dget_space(dataset.get()), H5Sclose);
  const std::array<hsize_t, 2> start{first, 0}, size{count, columns};
  if (H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr) < 0) return {};
  return space;
}

}  // namespace

std::string h5_reason() {
  std::string reason;
  const auto keep_innermost = [](unsigned, const H5E_error2_t* error, void* text) -> herr_t {
    if (error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep_innermost, &reason);
  return reason;
}

// ---- writing ----

H5Writer::H5Writer(const std::filesystem::path& path, std::string name) : name_(std::move(name)) {
  start_hdf5();
  file_ = {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose};
  need(file_.valid());
}

void H5Writer::fail() const {
  throw FailedError(name_, "can't be written: " + h5_reason(), "check the folder and the space left on the disk");
}

void H5Writer::write_attribute(hid_t object, const char* key, hid_t file_type, hid_t memory_type, const void* value) {
  const H5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const H5Handle attribute(H5Acreate2(object, key, file_type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  need(attribute.valid() && H5Awrite(attribute.get(), memory_type, value) >= 0);
}

void H5Writer::attribute(const char* key, const std::string& value) {
  attribute_of("/", key, value);
}

void H5Writer::attribute(const char* key, double value) {
  write_attribute(file_.get(), key, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void H5Writer::attribute(const char* key, std::uint8_t value) {
  write_attribute(file_.get(), key, H5T_STD_U8LE, H5T_NATIVE_UINT8, &value);
}

void H5Writer::attribute_of(const char* object, const char* key, const std::string& value) {
  const H5Handle owner(H5Oopen(file_.get(), object, H5P_DEFAULT), H5Oclose);
  need(owner.valid());
  const H5Handle type = text_type();
  const char* text = value.c_str();
  write_attribute(owner.get(), key, type.get(), type.get(), static_cast<const void*>(&text));
}

void H5Writer::group(const char* path) {
  const H5Handle list = creation(H5P_GROUP_CREATE);
  const H5Handle made(H5Gcreate2(file_.get(), path, H5P_DEFAULT, list.get(), H5P_DEFAULT), H5Gclose);
  need(made.valid());
}

void H5Writer::write_vector(const char* path, hid_t file_type, hid_t memory_type, std::size_t count,
                            const void* values) {
  constexpr std::size_t longest_chunk = std::size_t{1} << 18;
  const H5Handle space = space_of({count});
  // Nothing can't be cut into chunks.
  const H5Handle layout = count == 0 ? creation(H5P_DATASET_CREATE) : chunked({std::min(count, longest_chunk)});
  const H5Handle dataset(H5Dcreate2(file_.get(), path, file_type, space.get(), H5P_DEFAULT, layout.get(), H5P_DEFAULT),
                         H5Dclose);
  need(dataset.valid());
  need(count == 0 || H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
}

void H5Writer::vector(const char* path, const std::vector<std::uint32_t>& values) {
  write_vector(path, H5T_STD_U32LE, H5T_NATIVE_UINT32, values.size(), values.data());
}
void H5Writer::vector(const char* path, const std::vector<std::int64_t>& values) {
  write_vector(path, H5T_STD_I64LE, H5T_NATIVE_INT64, values.size(), values.data());
}
void H5Writer::vector(const char* path, const std::vector<double>& values) {
  write_vector(path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.size(), values.data());
}

void H5Writer::matrix(const char* path, std::uint64_t rows, std::uint64_t columns, std::uint64_t chunk_rows,
                      bool float32) {
  const H5Handle space = space_of({rows, columns}), layout = chunked({std::min(chunk_rows, rows), columns}),
                 access = chunk_cache(0);
  const hid_t type = float32 ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  matrix_ = {H5Dcreate2(file_.get(), path, type, space.get(), H5P_DEFAULT, layout.get(), access.get()), H5Dclose};
  need(matrix_.valid());
  matrix_columns_ = columns;
}

void H5Writer::write_rows(std::uint64_t first, std::uint64_t count, const double* values) {
  const H5Handle target = select_rows(matrix_, first, count, matrix_columns_);
  const H5Handle source = space_of({count, matrix_columns_});
  need(target.valid() &&
       H5Dwrite(matrix_.get(), H5T_NATIVE_DOUBLE, source.get(), target.get(), H5P_DEFAULT, values) >= 0);
}

void H5Writer::close() {
  need(matrix_.close());
  need(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL) >= 0 && file_.close());
}

// ---- reading ----

H5Reader::H5Reader(const std::filesystem::path& path) : name_(path.string()) {
  start_hdf5();
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) throw InputError(name_, "no such file", "check the name");
  const htri_t is_hdf5 = H5Fis_hdf5(path.c_str());
  if (is_hdf5 < 0) throw InputError(name_, "can't be opened", "check its permissions");
  if (is_hdf5 == 0) refuse("is not an HDF5 file", "write one with `calot precompute`");
  file_ = {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
  if (file_.valid()) return;
  const std::string reason = h5_reason();
  const bool truncated = reason.find("truncated") != std::string::npos;
  refuse(truncated ? "is truncated" : "is damaged (" + reason + ")", "compute it again with `calot precompute`");
}

void H5Reader::refuse(const std::string& what, const std::string& what_to_do) const {
  throw InputError(name_, what, what_to_do);
}

void H5Reader::refuse_damaged(const std::string& where) const {
  refuse("is damaged in " + where + " (" + h5_reason() + ")", "compute it again with `calot precompute`");
}

bool H5Reader::has(const char* path) const {
  return H5Lexists(file_.get(), path, H5P_DEFAULT) > 0 && H5Oexists_by_name(file_.get(), path, H5P_DEFAULT) > 0;
}

std::optional<std::string> H5Reader::text_attribute(const char* key) const {
  if (H5Aexists(file_.get(), key) <= 0) return {};
  const H5Handle attribute(H5Aopen(file_.get(), key, H5P_DEFAULT), H5Aclose);
  const H5Handle type(H5Aget_type(attribute.get()), H5Tclose), space(H5Aget_space(attribute.get()), H5Sclose);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1)
    refuse(std::string("its attribute ") + key + " is not text", "write it with `calot precompute`");
  if (H5Tis_variable_str(type.get()) > 0) {
    const H5Handle memory = text_type();
    H5Tset_cset(memory.get(), H5Tget_cset(type.get()));
    char* text = nullptr;
    if (H5Aread(attribute.get(), memory.get(), static_cast<void*>(&text)) < 0) refuse_damaged(key);
    std::string value = text == nullptr ? "" : text;
    H5free_memory(text);
    return value;
  }
  constexpr std::size_t longest = 4096;
  std::string value(H5Tget_size(type.get()), '\0');
  if (value.size() > longest || H5Aread(attribute.get(), type.get(), value.data()) < 0) refuse_damaged(key);
  return value.substr(0, value.find('\0'));
}

std::optional<double> H5Reader::number_attribute(const char* key) const {
  if (H5Aexists(file_.get(), key) <= 0) return {};
  const H5Handle attribute(H5Aopen(file_.get(), key, H5P_DEFAULT), H5Aclose);
  const H5Handle space(H5Aget_space(attribute.get()), H5Sclose);
  double value = 0;
  if (H5Sget_simple_extent_npoints(space.get()) != 1 || H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value) < 0)
    refuse(std::string("its attribute ") + key + " is not a number", "write it with `calot precompute`");
  return value;
}

H5Handle H5Reader::open_dataset(const char* path) const {
  constexpr std::size_t cache = std::size_t{32} << 20;  // for files with small chunks, written elsewhere
  if (!has(path)) refuse(std::string("has no ") + path, "write it with `calot precompute`");
  const H5Handle access = chunk_cache(cache);
  H5Handle dataset(H5Dopen2(file_.get(), path, access.get()), H5Dclose);
  if (!dataset.valid()) refuse_damaged(path);
  return dataset;
}

std::vector<std::uint64_t> H5Reader::dimensions(const H5Handle& dataset, const char* path) const {
  const H5Handle space(H5Dget_space(dataset.get()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) refuse_damaged(path);
  std::vector<hsize_t> sizes(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr);
  return {sizes.begin(), sizes.end()};
}

template <class T>
std::vector<T> H5Reader::vector(const char* path, std::uint64_t limit) const {
  const H5Handle dataset = open_dataset(path);
  const std::vector<std::uint64_t> sizes = dimensions(dataset, path);
  if (sizes.size() != 1 || sizes[0] > limit)
    refuse(std::string(path) + " has the wrong shape", "compute it again with `calot precompute`");
  hid_t type = H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, std::uint32_t>) type = H5T_NATIVE_UINT32;
  if constexpr (std::is_same_v<T, std::int64_t>) type = H5T_NATIVE_INT64;
  require_memory(sizes[0] * sizeof(T), name_);
  std::vector<T> values(sizes[0]);
  if (!values.empty() && H5Dread(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    refuse_damaged(path);
  return values;
}
template std::vector<std::uint32_t> H5Reader::vector(const char*, std::uint64_t) const;
template std::vector<std::int64_t> H5Reader::vector(const char*, std::uint64_t) const;
template std::vector<double> H5Reader::vector(const char*, std::uint64_t) const;

H5Reader::Shape H5Reader::open_matrix(const char* path) {
  matrix_ = open_dataset(path);
  const std::vector<std::uint64_t> sizes = dimensions(matrix_, path);
  const H5Handle type(H5Dget_type(matrix_.get()), H5Tclose);
  if (sizes.size() != 2 || H5Tget_class(type.get()) != H5T_FLOAT)
    refuse(std::string(path) + " is not a matrix of reals", "compute it again with `calot precompute`");
  matrix_columns_ = sizes[1];
  return {sizes[0], sizes[1], H5Tget_size(type.get()) <= sizeof(float)};
}

void H5Reader::read_rows(std::uint64_t first, std::uint64_t count, double* values) const {
  const H5Handle source = select_rows(matrix_, first, count, matrix_columns_);
  const H5Handle target = space_of({count, matrix_columns_});
  if (!source.valid() || H5Dread(matrix_.get(), H5T_NATIVE_DOUBLE, target.get(), source.get(), H5P_DEFAULT, values) < 0)
    refuse_damaged("rows " + std::to_string(first) + " to " + std::to_string(first + count - 1));
}

}  // namespace calot::detail
