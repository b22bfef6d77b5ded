#include "calot/base/files.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <vector>

#include "calot/base/error.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

using Digest = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;

Digest start_digest() {
  Digest digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr);
  return digest;
}

std::string finish_digest(const Digest& digest) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int size = 0;
  EVP_DigestFinal_ex(digest.get(), bytes.data(), &size);
  std::string hex;
  for (unsigned int i = 0; i < size; ++i) {
    constexpr std::string_view digits = "0123456789abcdef";
    hex += digits[bytes[i] >> 4];
    hex += digits[bytes[i] & 15];
  }
  return hex;
}

std::ifstream open_for_reading(const fs::path& path) {
  std::error_code code;
  if (fs::is_directory(path, code)) throw InputError(path.string(), "is a folder", "name a file");
  if (!fs::exists(path, code)) throw InputError(path.string(), "no such file", "check the name");
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw InputError(path.string(), std::string("can't be opened: ") + std::strerror(errno), "check its permissions");
  return in;
}

}  // namespace

std::string read_file(const fs::path& path, std::uint64_t limit) {
  std::ifstream in = open_for_reading(path);
  std::string text;
  std::vector<char> chunk(1 << 20);
  while (in.read(chunk.data(), static_cast<std::streamsize>(chunk.size())) || in.gcount() > 0) {
    text.append(chunk.data(), static_cast<std::size_t>(in.gcount()));
    if (text.size() > limit)
      throw InputError(path.string(), "is larger than " + std::to_string(limit) + " bytes", "use a smaller file");
  }
  return text;
}

fs::path partial_path(const fs::path& path) {
  return path.string() + ".partial-" + std::to_string(::getpid());
}

void commit_file(const fs::path& partial, const fs::path& path) {
  const int file = ::open(partial.c_str(), O_RDONLY | O_CLOEXEC);
  const bool flushed = file >= 0 && ::fsync(file) == 0;
  const int reason = errno;
  if (file >= 0) ::close(file);
  if (!flushed)
    throw FailedError(path.string(), std::string("can't be written: ") + std::strerror(reason), "free some space");
  std::error_code code;
  fs::rename(partial, path, code);
  if (code) throw FailedError(path.string(), "can't be written: " + code.message(), "check the folder");
}

PartialFile::~PartialFile() {
  std::error_code ignored;
  if (!committed_) fs::remove(partial_, ignored);
}

void PartialFile::commit() {
  commit_file(partial_, path_);
  committed_ = true;
}

void write_file(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  PartialFile partial(path);
  errno = 0;
  std::ofstream out(partial.path(), std::ios::binary);
  if (!out)
    throw FailedError(path.string(), std::string("can't be written: ") + std::strerror(errno),
                      "check the folder and its permissions");
  write(out);
  out.close();
  if (!out) throw FailedError(path.string(), "can't be written: the disk is full or gone", "free some space");
  partial.commit();
}

std::string sha256(std::span<const char> bytes) {
  const Digest digest = start_digest();
  EVP_DigestUpdate(digest.get(), bytes.data(), bytes.size());
  return finish_digest(digest);
}

std::string sha256_of_file(const fs::path& path) {
  std::ifstream in = open_for_reading(path);
  const Digest digest = start_digest();
  std::vector<char> chunk(1 << 20);
  while (in.read(chunk.data(), static_cast<std::streamsize>(chunk.size())) || in.gcount() > 0)
    EVP_DigestUpdate(digest.get(), chunk.data(), static_cast<std::size_t>(in.gcount()));
  return finish_digest(digest);
}

}  // namespace calot
