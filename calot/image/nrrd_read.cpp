#include <algorithm>

#include "calot/base/error.h"
#include "calot/image/nrrd.h"

namespace calot {
namespace {

constexpr std::size_t longest_header = std::size_t{16} << 20;

/// The header's text with the empty line that ends it, or the whole file where nothing follows (detached headers).
std::string read_text(ByteSource& source, std::size_t& length) {
  std::string text;
  std::string chunk(std::size_t{1} << 16, '\0');
  for (;;) {
    const std::size_t got = source.read(chunk.data(), chunk.size());
    const std::size_t from = text.size() < 4 ? 0 : text.size() - 4;
    text.append(chunk, 0, got);
    const auto unix_end = text.find("\n\n", from), dos_end = text.find("\n\r\n", from);
    if (unix_end != std::string::npos || dos_end != std::string::npos) {
      const auto end = std::min(unix_end, dos_end);
      length = end + (end == unix_end ? 2 : 3);
      return text.substr(0, end + 1);
    }
    if (got < chunk.size()) {
      length = text.size();
      return text;
    }
    if (!text.starts_with("NRRD")) return text;
    if (text.size() > longest_header)
      throw InputError(source.name(), "has a header of more than 16 MB without an end", "export the file again");
  }
}

void skip_lines(ByteSource& source, std::uint64_t lines) {
  for (char c = 0; lines > 0;) {
    if (source.read(&c, 1) == 0) return;
    if (c == '\n') --lines;
  }
}

}  // namespace

NrrdFile open_nrrd(const std::filesystem::path& path) {
  NrrdFile file;
  auto head = std::make_unique<ByteSource>(path);
  std::size_t length = 0;
  const std::string text = read_text(*head, length);
  file.header = parse_nrrd_header(text, path.string());
  const NrrdHeader& header = file.header;
  const bool detached = !header.data_file.empty();
  if (!detached && path.extension() == ".nhdr")
    throw InputError(path.string(), "has no field \"data file\"", "give the .nrrd file, or export it again");
  file.data = detached ? path.parent_path() / header.data_file : path;
  file.source = std::make_unique<ByteSource>(file.data);
  ByteSource& source = *file.source;
  if (!detached) source.skip(length);
  skip_lines(source, header.line_skip);
  const std::uint64_t bytes = header.grid.count() * header.components * bytes_of(header.stored.type);
  if (header.packed) {
    if (!source.is_packed())
      throw InputError(source.name(), "isn't compressed where its field \"encoding\" says gzip",
                       "export the file again");
    source.unpack();
  }
  const bool whole = header.byte_skip < 0 ? source.skip_to_last(bytes)
                                          : source.skip(static_cast<std::uint64_t>(header.byte_skip)) ==
                                                static_cast<std::uint64_t>(header.byte_skip);
  if (!whole)
    throw InputError(source.name(), "is truncated: it holds fewer voxels than its header says",
                     "copy or export the file again");
  return file;
}

}  // namespace calot
