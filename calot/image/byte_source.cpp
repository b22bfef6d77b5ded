#include "calot/image/byte_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "calot/base/error.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t chunk_size = std::size_t{1} << 18;

}  // namespace

ByteSource::ByteSource(const fs::path& path) : name_(path.string()) {
  std::error_code code;
  if (fs::is_directory(path, code)) throw InputError(name_, "is a folder", "name a file");
  if (!fs::exists(path, code)) throw InputError(name_, "no such file", "check the name");
  if (!fs::is_regular_file(path, code)) throw InputError(name_, "is no ordinary file", "name a file");
  in_.open(path, std::ios::binary);
  if (!in_) throw InputError(name_, std::string("can't be opened: ") + std::strerror(errno), "check its permissions");
  file_size_ = fs::file_size(path, code);
}

ByteSource::~ByteSource() {
  if (unpacking_) inflateEnd(&stream_);
}

std::uint64_t ByteSource::left_in_file() {
  const auto at = in_.tellg();
  return at < 0 ? 0 : file_size_ - std::min(file_size_, static_cast<std::uint64_t>(at));
}

bool ByteSource::is_packed() {
  const auto at = in_.tellg();
  char magic[2] = {};
  in_.read(magic, 2);
  in_.clear();
  in_.seekg(at);
  return magic[0] == '\x1f' && magic[1] == '\x8b';
}

void ByteSource::unpack() {
  if (inflateInit2(&stream_, 15 + 16) != Z_OK) throw FailedError(name_, "no memory to unpack it");
  unpacking_ = true;
  packed_.resize(chunk_size);
}

std::size_t ByteSource::read(char* into, std::size_t count) {
  if (unpacking_) return read_packed(into, count);
  in_.read(into, static_cast<std::streamsize>(count));
  const auto got = static_cast<std::size_t>(in_.gcount());
  if (got < count) in_.clear(std::ios::eofbit);
  return got;
}

std::uint64_t ByteSource::skip(std::uint64_t count) {
  std::vector<char> passed(static_cast<std::size_t>(std::min<std::uint64_t>(count, chunk_size)));
  std::uint64_t done = 0;
  while (done < count) {
    const auto got = read(passed.data(), static_cast<std::size_t>(std::min<std::uint64_t>(count - done, chunk_size)));
    done += got;
    if (got == 0) break;
  }
  return done;
}

bool ByteSource::skip_to_last(std::uint64_t count) {
  const std::uint64_t left = left_in_file();
  if (left < count) return false;
  in_.seekg(static_cast<std::streamoff>(left - count), std::ios::cur);
  return true;
}

bool ByteSource::could_hold(std::uint64_t count) {
  if (!unpacking_) return left_in_file() >= count;
  return (left_in_file() + stream_.avail_in) >= count / 1032;
}

void ByteSource::feed() {
  if (stream_.avail_in > 0) return;
  in_.read(packed_.data(), static_cast<std::streamsize>(packed_.size()));
  stream_.next_in = reinterpret_cast<Bytef*>(packed_.data());
  stream_.avail_in = static_cast<uInt>(in_.gcount());
}

/// After the end of one member: whether another follows, as pigz and bgzip write them.
bool ByteSource::next_member() {
  feed();
  if (stream_.avail_in == 0 || *stream_.next_in != 0x1f) return false;
  return inflateReset(&stream_) == Z_OK;
}

std::size_t ByteSource::read_packed(char* into, std::size_t count) {
  std::size_t taken = 0;
  while (taken < count && !ended_) {
    feed();
    const auto wanted = static_cast<uInt>(std::min<std::size_t>(count - taken, std::size_t{1} << 30));
    stream_.next_out = reinterpret_cast<Bytef*>(into + taken);
    stream_.avail_out = wanted;
    const bool dry = stream_.avail_in == 0;
    const int code = inflate(&stream_, Z_NO_FLUSH);
    const std::size_t got = wanted - stream_.avail_out;
    taken += got;
    if (code == Z_STREAM_END)
      ended_ = !next_member();
    else if (code == Z_BUF_ERROR || (code == Z_OK && got == 0 && dry))
      break;
    else if (code != Z_OK)
      throw InputError(name_, "its compressed data is damaged", "copy or export the file again");
  }
  return taken;
}

bool ByteSource::ends_well() {
  if (!unpacking_) return true;
  constexpr std::uint64_t enough = std::uint64_t{1} << 20;
  return skip(enough) == enough || ended_;
}

}  // namespace calot
