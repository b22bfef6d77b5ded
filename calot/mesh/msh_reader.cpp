#include "calot/mesh/msh_reader.h"

#include <algorithm>
#include <utility>

namespace calot::detail {

void NodeTags::index(const Cursor& at) {
  const bool counts_up = std::adjacent_find(tags_.begin(), tags_.end(),
                                            [](std::uint64_t a, std::uint64_t b) { return b != a + 1; }) == tags_.end();
  if (counts_up) return;
  for (std::size_t i = 0; i < tags_.size(); ++i) sorted_.push_back({tags_[i], static_cast<std::uint32_t>(i)});
  std::sort(sorted_.begin(), sorted_.end(),
            [](const Entry& a, const Entry& b) { return std::pair(a.tag, a.vertex) < std::pair(b.tag, b.vertex); });
  const auto twice =
      std::adjacent_find(sorted_.begin(), sorted_.end(), [](const Entry& a, const Entry& b) { return a.tag == b.tag; });
  if (twice != sorted_.end())
    at.fail("node " + std::to_string(twice->tag) + " is given twice", "number the nodes anew");
}

VertexId NodeTags::find(std::uint64_t tag, const Cursor& at) const {
  if (sorted_.empty()) {
    if (!tags_.empty() && tag >= tags_.front() && tag - tags_.front() < tags_.size())
      return VertexId(static_cast<std::size_t>(tag - tags_.front()));
  } else {
    const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), tag,
                                        [](const Entry& entry, std::uint64_t t) { return entry.tag < t; });
    if (found != sorted_.end() && found->tag == tag) return VertexId(std::size_t{found->vertex});
  }
  at.fail("a tetrahedron names node " + std::to_string(tag) + ", which the file doesn't have");
}

int MshReader::integer(const char* what) {
  return in_.binary() ? in_.value<std::int32_t>(what) : in_.number<std::int32_t>(what);
}

std::uint64_t MshReader::size(const char* what) {
  if (!in_.binary()) return in_.number<std::uint64_t>(what);
  return size_bytes_ == 8 ? in_.value<std::uint64_t>(what) : in_.value<std::uint32_t>(what);
}

double MshReader::real(const char* what) {
  return in_.binary() ? in_.value<double>(what) : in_.number<double>(what);
}

void MshReader::add_vertex() {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = in_.finite(real("a coordinate"), "a coordinate");
  raw_.mesh.positions.push_back(p);
}

void MshReader::add_tet(const std::array<std::uint64_t, 4>& nodes, int physical, int entity) {
  Tet tet;
  for (int c = 0; c < 4; ++c) tet[c] = nodes_.find(nodes[c], in_);
  raw_.mesh.tets.push_back(tet);
  physical_.push_back(physical);
  entity_.push_back(entity);
}

void MshReader::read_format() {
  const std::string_view version = in_.token("the version");
  version_4_ = version == "4.1";
  if (!version_4_ && version != "2" && version != "2.0" && version != "2.1" && version != "2.2")
    in_.fail("version " + in_quotes(version) + " of .msh", "save it as version 2.2 or 4.1 (gmsh -format msh41)");
  const int file_type = in_.number<int>("the file type");
  if (file_type != 0 && file_type != 1)
    in_.fail("file type " + std::to_string(file_type) + ", not 0 (ASCII) or 1 (binary)");
  size_bytes_ = in_.number<int>("the data size");
  if (size_bytes_ != 8 && !(version_4_ && size_bytes_ == 4))
    in_.fail("data size " + std::to_string(size_bytes_), "save it with 8-byte numbers");
  in_.rest_of_line();
  if (file_type == 0) return;
  in_.set_binary(true);
  in_.set_big_endian(false);
  const std::int32_t one = in_.value<std::int32_t>("the byte order mark");
  if (one == 0x01000000)
    in_.set_big_endian(true);
  else if (one != 1)
    in_.fail("the byte order mark is " + std::to_string(one) + ", not 1");
}

void MshReader::read_physical_names() {
  const std::size_t count = in_.count("physical names", 6);
  for (std::size_t i = 0; i < count; ++i) {
    const int dimension = in_.number<int>("a dimension"), tag = in_.number<int>("a physical group");
    const std::string_view line = in_.rest_of_line();
    const std::size_t open = line.find('"'), close = line.rfind('"');
    if (open == std::string_view::npos || close == open)
      in_.fail("a physical name in quotes expected, not " + in_quotes(line));
    if (dimension == 3)
      raw_.mesh.region_names.insert_or_assign(tag, std::string(line.substr(open + 1, close - open - 1)));
  }
}

std::uint64_t MshReader::node_number_2() {
  const int number = integer("a node number");
  if (number < 0) in_.fail("node number " + std::to_string(number));
  return static_cast<std::uint64_t>(number);
}

void MshReader::read_nodes_2() {
  const std::uint64_t announced = in_.number<std::uint64_t>("a number of nodes");
  in_.rest_of_line();
  check_size(announced, 0, in_);
  const std::size_t count = in_.checked_count(announced, in_.binary() ? 28 : 8, "nodes");
  for (std::size_t i = 0; i < count; ++i) {
    nodes_.add(node_number_2());
    add_vertex();
  }
  nodes_.index(in_);
}

/// In binary files a header announces several elements of one type; in ASCII each element is a block of its own.
void MshReader::read_element_block_2() {
  if (!in_.binary()) integer("an element number");
  const int type = integer("an element type");
  const ElementKind kind = gmsh_element(type);
  const bool wanted = is_wanted(kind, type, in_);
  const int announced = in_.binary() ? integer("a number of elements") : 1, tags = integer("a number of tags");
  if (announced < 1 || tags < 0) in_.fail("a negative count");
  const std::size_t words = std::size_t(tags) + std::size_t(kind.nodes) + (in_.binary() ? 1 : 0);
  in_.checked_count(std::uint64_t(announced), words * (in_.binary() ? 4 : 2), "elements");
  for (int e = 0; e < announced; ++e) {
    if (in_.binary()) integer("an element number");
    std::array<int, 2> tag{};
    for (int i = 0; i < tags; ++i) {
      const int value = integer("a tag");
      if (i < 2) tag[i] = value;
    }
    std::array<std::uint64_t, 4> nodes{};
    for (int i = 0; i < kind.nodes; ++i) {
      const std::uint64_t node = node_number_2();
      if (wanted) nodes[i] = node;
    }
    if (wanted)
      add_tet(nodes, tag[0], tag[1]);
    else
      ++raw_.ignored[kind.name];
  }
}

void MshReader::read_elements_2() {
  const std::uint64_t announced = in_.number<std::uint64_t>("a number of elements");
  in_.rest_of_line();
  check_size(0, announced, in_);
  const std::size_t count = in_.checked_count(announced, 8, "elements");
  const auto elements_so_far = [&] {
    std::size_t sum = raw_.mesh.tet_count();
    for (const auto& [kind, ignored] : raw_.ignored) sum += ignored;
    return sum;
  };
  if (!in_.binary()) {
    for (std::size_t i = 0; i < count; ++i) read_element_block_2();
    return;
  }
  while (elements_so_far() < count) read_element_block_2();
  if (elements_so_far() != count)
    in_.fail(std::to_string(elements_so_far()) + " elements where " + std::to_string(count) + " were announced");
}

void MshReader::read_section(std::string_view section) {
  if (section == "MeshFormat") {
    read_format();
    has_format_ = true;
    return;
  }
  if (!has_format_) in_.fail("$" + std::string(section) + " before $MeshFormat", "save it as version 2.2 or 4.1");
  if (section == "PhysicalNames") return read_physical_names();
  if (section == "Entities" && version_4_) return read_entities_4();
  if (section == "PartitionedEntities") in_.fail("the mesh is partitioned", "save it without partitions");
  if (section == "Nodes") {
    if (std::exchange(has_nodes_, true)) in_.fail("a second $Nodes section");
    return version_4_ ? read_nodes_4() : read_nodes_2();
  }
  if (section == "Elements") {
    if (!has_nodes_) in_.fail("$Elements before $Nodes");
    if (std::exchange(has_elements_, true)) in_.fail("a second $Elements section");
    return version_4_ ? read_elements_4() : read_elements_2();
  }
  // Fields, periodicity and comments are none of our business; they end at their $End line.
  const std::string end = "\n$End" + std::string(section);
  in_.seek(in_.position() - 1);  // an empty section ends at the line end just passed
  if (!in_.skip_past(end)) in_.fail("section $" + std::string(section) + " doesn't end");
  in_.seek(in_.position() - end.size());
}

/// Physical groups are the regions. A mesh without any has its geometric entities instead; mixing the two would let a
/// group and an entity of the same number run together.
void MshReader::set_regions() {
  const bool grouped = std::any_of(physical_.begin(), physical_.end(), [](int group) { return group != 0; });
  const std::vector<int>& regions = grouped ? physical_ : entity_;
  raw_.mesh.regions.assign(regions.begin(), regions.end());
  const auto without = std::count(physical_.begin(), physical_.end(), 0);
  if (grouped && without > 0)
    raw_.notes.push_back(std::to_string(without) + " tets belong to no physical group; their region is 0");
}

RawMesh MshReader::read() {
  while (in_.skip_space()) {
    in_.set_section("");
    const std::string_view line = in_.rest_of_line();
    const std::string section(line.substr(0, line.find_last_not_of(" \t") + 1));
    if (section.size() < 2 || section[0] != '$') in_.fail("a section such as $Nodes expected, not " + in_quotes(line));
    in_.set_section(section);
    read_section(std::string_view(section).substr(1));
    const std::string_view end = in_.token("the section's end");
    if (end != "$End" + section.substr(1)) in_.fail("$End" + section.substr(1) + " expected, not " + in_quotes(end));
  }
  in_.set_section("");
  if (!has_format_) in_.fail("no $MeshFormat: not a .msh file, or an empty one", "export the mesh again");
  if (!has_nodes_ || !has_elements_) in_.fail("no $Nodes or no $Elements", "the file is cut short; export it again");
  set_regions();
  return std::move(raw_);
}

MeshFile parse_msh(std::string_view bytes, const std::string& name, double scale) {
  return finish(MshReader(bytes, name).read(), name, scale);
}

}  // namespace calot::detail
