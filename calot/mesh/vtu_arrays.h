// Inside this room only: the <DataArray> elements of a .vtu file, in all their encodings.
#pragma once
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "calot/mesh/base64.h"
#include "calot/mesh/vtk_arrays.h"

namespace calot::detail {

/// What the head of the file says about all arrays.
struct VtuEncoding {
  bool swap = false;             ///< the file's byte order is not the machine's
  std::size_t header_bytes = 4;  ///< of each number in a binary array's header
  bool zlib = false;
  bool appended_base64 = false;
  std::string_view appended;  ///< behind the underscore of <AppendedData>
};

/// Decodes arrays; errors name file, line and array.
class VtuArrays {
 public:
  VtuArrays(std::string_view xml, const std::string& name) : xml_(xml), name_(name) {}
  void set_encoding(const VtuEncoding& encoding) { encoding_ = encoding; }

  /// A cursor at an element, for messages.
  [[nodiscard]] Cursor at(pugi::xml_node node) const;
  /// The numbers of an array, as double or std::int64_t.
  template <class T>
  std::vector<T> read(pugi::xml_node array) const;

 private:
  template <class T>
  std::vector<T> read_ascii(pugi::xml_node array) const;
  [[nodiscard]] ByteStream stream_of(pugi::xml_node array, const Cursor& here) const;
  [[nodiscard]] std::vector<std::uint64_t> read_header(ByteStream& stream, std::size_t count, const Cursor& here) const;
  [[nodiscard]] std::string read_bytes(ByteStream& stream, const Cursor& here) const;
  [[nodiscard]] std::string inflate_blocks(ByteStream& stream, const Cursor& here) const;

  std::string_view xml_;
  std::string name_;
  VtuEncoding encoding_;
};

}  // namespace calot::detail
