// Inside this room only: the little of HDF5's C interface that compliance files need, with owners and errors.
#pragma once
#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace calot::detail {

/// Owns one HDF5 identifier.
class H5Handle {
 public:
  using Close = herr_t (*)(hid_t);
  H5Handle() = default;
  H5Handle(hid_t id, Close close_with) : id_(id), close_(close_with) {}
  ~H5Handle() { close(); }
  H5Handle(H5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  H5Handle& operator=(H5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  [[nodiscard]] hid_t get() const { return id_; }
  [[nodiscard]] bool valid() const { return id_ >= 0; }
  /// Closes now; false if that failed, e.g. because the last bytes could not be written.
  bool close() { return !valid() || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

/// What went wrong innermost in the last failed HDF5 call.
std::string h5_reason();

/// An HDF5 file being written. Everything throws FailedError naming `name` (the file as the user knows it).
class H5Writer {
 public:
  H5Writer(const std::filesystem::path& path, std::string name);
  void attribute(const char* key, const std::string& value);
  void attribute(const char* key, double value);
  void attribute(const char* key, std::uint8_t value);
  /// An attribute of a dataset or group.
  void attribute_of(const char* object, const char* key, const std::string& value);
  void group(const char* path);
  void vector(const char* path, const std::vector<std::uint32_t>& values);
  void vector(const char* path, const std::vector<std::int64_t>& values);
  void vector(const char* path, const std::vector<double>& values);

  /// Creates a rows × columns matrix of reals in checksummed chunks of `chunk_rows` whole rows.
  void matrix(const char* path, std::uint64_t rows, std::uint64_t columns, std::uint64_t chunk_rows, bool float32);
  /// Writes `count` rows of the matrix made last; aligned with its chunks this needs no buffer.
  void write_rows(std::uint64_t first, std::uint64_t count, const double* values);
  /// Flushes and closes.
  void close();

 private:
  [[noreturn]] void fail() const;
  void need(bool done) const {
    if (!done) fail();
  }
  void write_attribute(hid_t object, const char* key, hid_t file_type, hid_t memory_type, const void* value);
  void write_vector(const char* path, hid_t file_type, hid_t memory_type, std::size_t count, const void* values);

  std::string name_;
  H5Handle file_, matrix_;
  std::uint64_t matrix_columns_ = 0;
};

/// An HDF5 file being read. Everything throws InputError naming the file and the reason.
class H5Reader {
 public:
  explicit H5Reader(const std::filesystem::path& path);
  [[noreturn]] void refuse(const std::string& what, const std::string& what_to_do) const;
  [[nodiscard]] bool has(const char* path) const;
  [[nodiscard]] std::optional<std::string> text_attribute(const char* key) const;
  [[nodiscard]] std::optional<double> number_attribute(const char* key) const;
  /// A one-dimensional array of at most `limit` whole numbers or reals; T is std::uint32_t, std::int64_t or double.
  template <class T>
  [[nodiscard]] std::vector<T> vector(const char* path, std::uint64_t limit) const;

  struct Shape {
    std::uint64_t rows = 0, columns = 0;
    bool float32 = false;
  };
  /// Opens a matrix of reals.
  Shape open_matrix(const char* path);
  void read_rows(std::uint64_t first, std::uint64_t count, double* values) const;

 private:
  [[nodiscard]] H5Handle open_dataset(const char* path) const;
  [[nodiscard]] std::vector<std::uint64_t> dimensions(const H5Handle& dataset, const char* path) const;
  [[noreturn]] void refuse_damaged(const std::string& where) const;

  std::string name_;
  H5Handle file_, matrix_;
  std::uint64_t matrix_columns_ = 0;
};

}  // namespace calot::detail
