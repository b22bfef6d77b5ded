// Files: whole or not at all.
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string>

namespace calot {

/// Reads a whole file. Throws InputError if it is missing, is a folder, or is larger than `limit` bytes.
std::string read_file(const std::filesystem::path& path, std::uint64_t limit = std::uint64_t{8} << 30);

/// Writes a file beside its name and renames it when whole; on any failure the old file, if any, stays as it was.
/// `write` gets the stream; a full disk throws FailedError.
void write_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

/// The name to write to before `commit_file` renames it; for writers that need a path, not a stream.
std::filesystem::path partial_path(const std::filesystem::path& path);
/// Flushes and renames the partial file to its name. Throws FailedError.
void commit_file(const std::filesystem::path& partial, const std::filesystem::path& path);

/// Removes a partial file when left without a commit.
class PartialFile {
 public:
  explicit PartialFile(std::filesystem::path path) : path_(std::move(path)), partial_(partial_path(path_)) {}
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return partial_; }
  void commit();

 private:
  std::filesystem::path path_, partial_;
  bool committed_ = false;
};

/// SHA-256 as 64 hexadecimal digits.
std::string sha256(std::span<const char> bytes);
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace calot
