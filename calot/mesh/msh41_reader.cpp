// The sections of .msh 4.1, which differ from version 2 throughout.
#include <algorithm>

#include "calot/mesh/msh_reader.h"

namespace calot::detail {

/// A count of items, each of at least this many numbers; of four bytes at least in binary, two in ASCII.
std::size_t MshReader::count_4(const char* what, std::size_t words_each) {
  const std::uint64_t announced = size(what);
  return in_.checked_count(announced, words_each * (in_.binary() ? 4 : 2), what);
}

void MshReader::read_entity_4(int dimension) {
  const int tag = integer("an entity number");
  for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) real("a bound");
  const std::size_t groups = count_4("physical groups", 1);
  for (std::size_t i = 0; i < groups; ++i) {
    const int group = integer("a physical group");
    if (dimension == 3 && i == 0) physical_of_volume_[tag] = group;
  }
  if (dimension == 3 && groups > 1)
    raw_.notes.push_back("volume " + std::to_string(tag) + " belongs to " + std::to_string(groups) +
                         " physical groups; the first is its region");
  if (dimension == 0) return;
  const std::size_t boundary = count_4("bounding entities", 1);
  for (std::size_t i = 0; i < boundary; ++i) integer("a bounding entity");
}

void MshReader::read_entities_4() {
  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = count_4("entities", 5);
  for (int dimension = 0; dimension < 4; ++dimension)
    for (std::size_t i = 0; i < counts[dimension]; ++i) read_entity_4(dimension);
}

void MshReader::read_node_block_4() {
  const int dimension = integer("an entity dimension");
  integer("an entity number");
  const int parametric = integer("whether nodes are parametric");
  if (dimension < 0 || dimension > 3) in_.fail("entity dimension " + std::to_string(dimension));
  const std::size_t count = count_4("nodes", 4);
  check_size(nodes_.size() + count, 0, in_);
  for (std::size_t i = 0; i < count; ++i) nodes_.add(size("a node number"));
  for (std::size_t i = 0; i < count; ++i) {
    add_vertex();
    for (int p = 0; p < (parametric != 0 ? dimension : 0); ++p) real("a parametric coordinate");
  }
}

void MshReader::read_nodes_4() {
  const std::size_t blocks = count_4("node blocks", 4), count = count_4("nodes", 4);
  size("the smallest node number");
  size("the largest node number");
  for (std::size_t b = 0; b < blocks; ++b) read_node_block_4();
  if (nodes_.size() != count)
    in_.fail(std::to_string(nodes_.size()) + " nodes where " + std::to_string(count) + " were announced");
  nodes_.index(in_);
}

void MshReader::read_element_block_4() {
  const int dimension = integer("an entity dimension"), entity = integer("an entity number");
  const int type = integer("an element type");
  const ElementKind kind = gmsh_element(type);
  const bool wanted = is_wanted(kind, type, in_);
  if (wanted && dimension != 3) in_.fail("tetrahedra on an entity of dimension " + std::to_string(dimension));
  const std::size_t count = count_4("elements", 1 + std::size_t(kind.nodes));
  check_size(0, raw_.mesh.tet_count() + count, in_);
  const auto group = physical_of_volume_.find(entity);
  for (std::size_t e = 0; e < count; ++e) {
    size("an element number");
    std::array<std::uint64_t, 4> nodes{};
    for (int i = 0; i < kind.nodes; ++i) {
      const std::uint64_t node = size("a node number");
      if (wanted) nodes[i] = node;
    }
    if (wanted) add_tet(nodes, group == physical_of_volume_.end() ? 0 : group->second, entity);
  }
  if (!wanted && count > 0) raw_.ignored[kind.name] += count;
}

void MshReader::read_elements_4() {
  const std::size_t blocks = count_4("element blocks", 4), count = count_4("elements", 2);
  size("the smallest element number");
  size("the largest element number");
  for (std::size_t b = 0; b < blocks; ++b) read_element_block_4();
  std::size_t found = raw_.mesh.tet_count();
  for (const auto& [kind, ignored] : raw_.ignored) found += ignored;
  if (found != count) in_.fail(std::to_string(found) + " elements where " + std::to_string(count) + " were announced");
}

}  // namespace calot::detail
