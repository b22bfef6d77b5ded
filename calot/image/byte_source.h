// Inside this room only. The bytes of a file in order, unpacked on the way where they are gzip: never the whole file.
#pragma once
#include <zlib.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace calot {

/// Files may be hostile: nothing is believed about how much there is until it was read.
class ByteSource {
 public:
  /// Opens a file. Throws InputError: missing, a folder or another thing that is no file, no permission.
  explicit ByteSource(const std::filesystem::path& path);
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Whether the bytes from here on begin as gzip does. Only before `unpack`.
  bool is_packed();
  /// From here on the file is gzip (one or several members).
  void unpack();
  /// Reads up to `count` bytes. @return how many there were. Throws InputError where compressed bytes are damaged.
  std::size_t read(char* into, std::size_t count);
  /// Passes over bytes. @return how many there were
  std::uint64_t skip(std::uint64_t count);
  /// Passes over everything but the last `count` bytes. Only before `unpack`. @return whether there were so many
  bool skip_to_last(std::uint64_t count);
  /// Whether the rest of the file could hold so many bytes at all (gzip packs to a 1032th at best).
  bool could_hold(std::uint64_t count);
  /// Whether nothing but a whole end follows, or more than a megabyte that nobody asked for. Bytes that aren't packed
  /// always end well.
  bool ends_well();

 private:
  std::uint64_t left_in_file();
  void feed();
  std::size_t read_packed(char* into, std::size_t count);
  bool next_member();

  std::string name_;
  std::ifstream in_;
  std::uint64_t file_size_ = 0;
  bool unpacking_ = false, ended_ = false;
  z_stream stream_{};
  std::vector<char> packed_;
};

}  // namespace calot
