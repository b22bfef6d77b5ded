// Inside this room only: Gmsh's .msh files, versions 2.x and 4.1, ASCII and binary of either byte order.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "calot/mesh/raw_mesh.h"

namespace calot::detail {

/// Gmsh numbers its nodes as it likes; this finds the vertex, in order of appearance, that a node number stands for.
class NodeTags {
 public:
  void add(std::uint64_t tag) { tags_.push_back(tag); }
  [[nodiscard]] std::size_t size() const { return tags_.size(); }
  /// To be called after the last `add`. Fails at the cursor when a number was given twice.
  void index(const Cursor& at);
  /// The vertex of a node number; fails at the cursor when there is no such node.
  [[nodiscard]] VertexId find(std::uint64_t tag, const Cursor& at) const;

 private:
  struct Entry {
    std::uint64_t tag;
    std::uint32_t vertex;
  };
  std::vector<std::uint64_t> tags_;
  std::vector<Entry> sorted_;  // empty when tags_ counts up by one
};

/// Reads one .msh file; the functions are the sections of Gmsh's reference manual, chapter "Gmsh file formats".
class MshReader {
 public:
  MshReader(std::string_view bytes, const std::string& name) : in_(bytes, name) {}
  RawMesh read();

 private:
  void read_format();
  void read_section(std::string_view section);
  void read_physical_names();
  void read_nodes_2();
  void read_elements_2();
  void read_element_block_2();
  void read_entities_4();
  void read_entity_4(int dimension);
  void read_nodes_4();
  void read_node_block_4();
  void read_elements_4();
  void read_element_block_4();
  void set_regions();

  int integer(const char* what);
  std::uint64_t node_number_2();
  std::uint64_t size(const char* what);
  double real(const char* what);
  std::size_t count_4(const char* what, std::size_t words_each);
  void add_vertex();
  void add_tet(const std::array<std::uint64_t, 4>& nodes, int physical, int entity);

  Cursor in_;
  RawMesh raw_;
  NodeTags nodes_;
  bool version_4_ = false, has_nodes_ = false, has_elements_ = false, has_format_ = false;
  int size_bytes_ = 8;                     // of a size_t in a binary version-4 file
  std::map<int, int> physical_of_volume_;  // version 4: the first physical group of each volume
  std::vector<int> physical_, entity_;     // of each tet; 0 is "none"
};

}  // namespace calot::detail
