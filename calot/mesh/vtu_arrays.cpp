#include "calot/mesh/vtu_arrays.h"

#include <zlib.h>

#include <algorithm>

namespace calot::detail {
namespace {

// DEFLATE can't do better than 1032 to 1; a header that promises more is lying.
constexpr std::uint64_t best_compression = 1032;

[[noreturn]] void fail_short(const Cursor& here) {
  here.fail("the array's data end too early, or are not base64");
}

std::string checked_read(ByteStream& stream, std::uint64_t size, const Cursor& here) {
  if (size > stream.at_most()) fail_short(here);
  std::string bytes = stream.read(static_cast<std::size_t>(size));
  if (bytes.size() != size) fail_short(here);
  return bytes;
}

}  // namespace

Cursor VtuArrays::at(pugi::xml_node node) const {
  Cursor cursor(xml_, name_);
  if (node.offset_debug() > 0) cursor.seek(static_cast<std::size_t>(node.offset_debug()));
  std::string element = std::string("<") + node.name();
  if (const char* name = node.attribute("Name").value(); *name != 0) element += " Name=" + in_quotes(name);
  cursor.set_section(element + ">");
  return cursor;
}

ByteStream VtuArrays::stream_of(pugi::xml_node array, const Cursor& here) const {
  const std::string_view format = array.attribute("format").value();
  if (format == "binary") return {array.child_value(), true};
  if (format != "appended") here.fail("array format " + in_quotes(format) + ", not ascii, binary or appended");
  const std::string_view word = array.attribute("offset").value();
  const auto offset = here.number_in<std::uint64_t>(word, "the attribute offset");
  if (offset > encoding_.appended.size())
    here.fail("offset " + std::to_string(offset) + " lies behind the end of the appended data");
  return {encoding_.appended.substr(static_cast<std::size_t>(offset)), encoding_.appended_base64};
}

std::vector<std::uint64_t> VtuArrays::read_header(ByteStream& stream, std::size_t count, const Cursor& here) const {
  if (count > stream.at_most() / encoding_.header_bytes) fail_short(here);
  const std::string bytes = checked_read(stream, count * encoding_.header_bytes, here);
  std::vector<std::uint64_t> header(count);
  for (std::size_t i = 0; i < count; ++i) {
    const char* number = bytes.data() + i * encoding_.header_bytes;
    header[i] = encoding_.header_bytes == 8 ? load<std::uint64_t>(number, encoding_.swap)
                                            : load<std::uint32_t>(number, encoding_.swap);
  }
  return header;
}

/// A compressed array: number of blocks, size of a block, size of the last one if shorter, each block's compressed
/// size.
std::string VtuArrays::inflate_blocks(ByteStream& stream, const Cursor& here) const {
  const std::vector<std::uint64_t> head = read_header(stream, 3, here);
  const std::uint64_t blocks = head[0], block_size = head[1], last_size = head[2];
  if (blocks > stream.at_most()) fail_short(here);
  const std::vector<std::uint64_t> sizes = read_header(stream, static_cast<std::size_t>(blocks), here);
  std::string bytes;
  for (std::size_t b = 0; b < sizes.size(); ++b) {
    const std::string packed = checked_read(stream, sizes[b], here);
    const std::uint64_t size = b + 1 == sizes.size() && last_size != 0 ? last_size : block_size;
    if (size > best_compression * (packed.size() + 1))
      here.fail("a compressed block of " + std::to_string(packed.size()) + " bytes claims to hold " +
                std::to_string(size));
    const std::size_t start = bytes.size();
    bytes.resize(start + static_cast<std::size_t>(size));
    uLongf length = static_cast<uLongf>(size);
    const int status = uncompress(reinterpret_cast<Bytef*>(bytes.data() + start), &length,
                                  reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
    if (status != Z_OK || length != size) here.fail("compressed block " + std::to_string(b) + " is damaged");
  }
  return bytes;
}

std::string VtuArrays::read_bytes(ByteStream& stream, const Cursor& here) const {
  if (encoding_.zlib) return inflate_blocks(stream, here);
  return checked_read(stream, read_header(stream, 1, here)[0], here);
}

template <class T>
std::vector<T> VtuArrays::read_ascii(pugi::xml_node array) const {
  const std::string_view text = array.child_value();
  Cursor words = at(array);
  if (const std::ptrdiff_t start = array.first_child().offset_debug(); start > 0) {
    const std::string_view before = xml_.substr(0, static_cast<std::size_t>(start));
    words = Cursor(text, name_, 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n')));
    words.set_section(std::string("<DataArray Name=") + in_quotes(array.attribute("Name").value()) + ">");
  }
  std::vector<T> values;
  if (text.empty()) return values;
  while (words.skip_space()) values.push_back(words.number<T>("a number"));
  return values;
}

template <class T>
std::vector<T> VtuArrays::read(pugi::xml_node array) const {
  if (std::string_view(array.attribute("format").value()) == "ascii") return read_ascii<T>(array);
  const Cursor here = at(array);
  const std::string_view type_name = array.attribute("type").value();
  const auto type = vtu_type(type_name);
  if (!type) here.fail("unknown data type " + in_quotes(type_name), "use Float64 or Int64");
  ByteStream stream = stream_of(array, here);
  const std::string bytes = read_bytes(stream, here);
  if (bytes.size() % bytes_of(*type) != 0)
    here.fail(std::to_string(bytes.size()) + " bytes are no whole number of " + std::string(type_name));
  return decode<T>(*type, bytes, encoding_.swap, here);
}

template std::vector<double> VtuArrays::read<double>(pugi::xml_node) const;
template std::vector<std::int64_t> VtuArrays::read<std::int64_t>(pugi::xml_node) const;

}  // namespace calot::detail
