#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "calot/base/error.h"
#include "calot/image/nrrd.h"
#include "calot/image/text.h"

namespace calot {
namespace {

constexpr std::size_t largest_count = std::size_t{1} << 31;  // of voxels, as for NIfTI
constexpr std::size_t most_components = 4096;

std::string lower(std::string_view text) {
  std::string small(text);
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return small;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space = " \t\r";
  const auto begin = text.find_first_not_of(space);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(space) - begin + 1);
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> found;
  while (!(text = trimmed(text)).empty()) {
    const auto end = std::min(text.find_first_of(" \t"), text.size());
    found.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return found;
}

template <class T>
bool parse_number(std::string_view text, T& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size() && !text.empty();
}

/// One "field: value" line.
struct Field {
  std::string value;
  std::size_t line = 0;
};

class Parser {
 public:
  Parser(std::string_view text, std::string where) : where_(std::move(where)) { read_lines(text); }
  NrrdHeader header();

 private:
  void read_lines(std::string_view text);
  void read_line(std::string_view line, std::size_t number);
  [[noreturn]] void wrong(const std::string& field, const std::string& what, const std::string& advice) const;
  [[nodiscard]] const std::string* find(const std::string& field) const;
  [[nodiscard]] const std::string& need(const std::string& field, const std::string& advice) const;
  template <class T>
  std::vector<T> numbers(const std::string& field, std::size_t count) const;
  void read_axes();
  void read_size(NrrdHeader& header) const;
  void check_kinds() const;
  void read_space(NrrdHeader& header) const;
  [[nodiscard]] Eigen::Vector3d read_signs() const;
  [[nodiscard]] double read_unit() const;
  [[nodiscard]] std::optional<Eigen::Vector3d> vector(std::string_view& rest, const std::string& field) const;
  void read_numbers(NrrdHeader& header) const;
  void read_data(NrrdHeader& header) const;

  std::string where_;
  std::map<std::string, Field> fields_;
  std::map<std::string, std::string> pairs_;
  std::size_t dimension_ = 0;
  std::vector<std::optional<Eigen::Vector3d>> directions_;  // empty: not in space
  std::optional<std::size_t> list_axis_;
};

void Parser::wrong(const std::string& field, const std::string& what, const std::string& advice) const {
  const auto at = fields_.find(field);
  throw InputError(at == fields_.end() ? where_ : at_line(where_, at->second.line),
                   "its field \"" + field + "\" " + what, advice);
}

const std::string* Parser::find(const std::string& field) const {
  const auto at = fields_.find(field);
  return at == fields_.end() ? nullptr : &at->second.value;
}

const std::string& Parser::need(const std::string& field, const std::string& advice) const {
  if (const std::string* value = find(field)) return *value;
  throw InputError(where_, "has no field \"" + field + "\"", advice);
}

void Parser::read_lines(std::string_view text) {
  std::size_t number = 0;
  while (!text.empty()) {
    const auto end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (++number > 1) {
      read_line(line, number);
    } else if (line.size() != 8 || !line.starts_with("NRRD000") || line[7] < '1' || line[7] > '5') {
      throw InputError(where_, "is not NRRD (no \"NRRD0001\" … \"NRRD0005\" at its beginning)",
                       "give a .nrrd or .nhdr file");
    }
  }
  if (number == 0) throw InputError(where_, "is empty", "export the file again");
}

std::string unescaped(std::string_view text) {
  std::string plain;
  for (std::size_t c = 0; c < text.size(); ++c) {
    const bool escaped = text[c] == '\\' && c + 1 < text.size() && (text[c + 1] == 'n' || text[c + 1] == '\\');
    plain += escaped ? (text[++c] == 'n' ? '\n' : '\\') : text[c];
  }
  return plain;
}

void Parser::read_line(std::string_view line, std::size_t number) {
  if (line.empty() || line[0] == '#') return;
  const auto pair = line.find(":="), colon = line.find(": ");
  if (pair != std::string_view::npos && pair < colon) {
    if (!pairs_.emplace(line.substr(0, pair), unescaped(line.substr(pair + 2))).second)
      throw InputError(at_line(where_, number), "gives the key " + in_quotes(line.substr(0, pair)) + " twice",
                       "export the file again");
    return;
  }
  const auto end = colon != std::string_view::npos ? colon : line.find(':');
  if (end == std::string_view::npos)
    throw InputError(at_line(where_, number), "has a line that is no field: " + in_quotes(line),
                     "export the file again");
  std::string field = lower(trimmed(line.substr(0, end)));
  if (field == "datafile") field = "data file";
  if (field == "lineskip") field = "line skip";
  if (field == "byteskip") field = "byte skip";
  if (!fields_.emplace(field, Field{std::string(trimmed(line.substr(end + 1))), number}).second)
    throw InputError(at_line(where_, number), "gives the field " + in_quotes(field) + " twice",
                     "export the file again");
}

template <class T>
std::vector<T> Parser::numbers(const std::string& field, std::size_t count) const {
  const std::string& text = need(field, "export the file again");
  std::vector<T> values;
  for (const std::string_view word : words(text)) {
    T value{};
    if (!parse_number(word, value) || values.size() == count) break;
    values.push_back(value);
  }
  if (values.size() != count || words(text).size() != count)
    wrong(field, "isn't " + std::to_string(count) + " whole numbers: " + in_quotes(text), "export the file again");
  return values;
}

/// "(x,y,z)" or "none" at the beginning of `rest`, which loses it.
std::optional<Eigen::Vector3d> Parser::vector(std::string_view& rest, const std::string& field) const {
  rest = trimmed(rest);
  if (lower(rest.substr(0, 4)) == "none") {
    rest.remove_prefix(4);
    return {};
  }
  const auto end = rest.find(')');
  Eigen::Vector3d value;
  bool good = rest.starts_with('(') && end != std::string_view::npos;
  std::string_view inside = good ? rest.substr(1, end - 1) : std::string_view();
  for (int d = 0; d < 3 && good; ++d) {
    const auto comma = d < 2 ? inside.find(',') : inside.size();
    good = comma != std::string_view::npos && parse_number(trimmed(inside.substr(0, comma)), value[d]);
    if (good && d < 2) inside.remove_prefix(comma + 1);
  }
  if (!good) wrong(field, "has no vector (x,y,z) at " + in_quotes(rest), "export the file again with its orientation");
  rest.remove_prefix(end + 1);
  return value;
}

void Parser::read_axes() {
  dimension_ = numbers<std::size_t>("dimension", 1)[0];
  if (dimension_ != 3 && dimension_ != 4)
    wrong("dimension", "says " + std::to_string(dimension_) + ", not three (or four, with 3D Slicer's layers)",
          "export one volume");
  std::string_view rest = need("space directions", "export it again with its orientation");
  for (std::size_t axis = 0; axis < dimension_; ++axis) {
    directions_.push_back(vector(rest, "space directions"));
    if (directions_.back()) continue;
    if (dimension_ == 3 || list_axis_)
      wrong("space directions", "leaves less than three axes in space", "export one volume");
    list_axis_ = axis;
  }
  if (!trimmed(rest).empty()) wrong("space directions", "has more vectors than axes", "export the file again");
  if (dimension_ == 4 && !list_axis_)
    wrong("space directions", "has four axes in space, of which one would be time", "export one volume");
  if (list_axis_ && *list_axis_ != 0 && *list_axis_ != 3)
    wrong("space directions", "has its list of layers between the axes in space", "export the file again");
}

void Parser::read_size(NrrdHeader& header) const {
  const auto sizes = numbers<std::size_t>("sizes", dimension_);
  std::size_t axis = 0;
  for (std::size_t d = 0; d < dimension_; ++d) {
    const bool list = list_axis_ == d;
    if (sizes[d] == 0 || sizes[d] > (list ? most_components : largest_count))
      wrong("sizes", "has " + std::to_string(sizes[d]) + " along axis " + std::to_string(d), "export the file again");
    if (list)
      header.components = sizes[d];
    else
      header.grid.size[axis++] = sizes[d];
  }
  header.components_first = list_axis_ != std::optional<std::size_t>(3);
  std::size_t count = 1;
  for (const std::size_t n : sizes) {
    if (count > 4 * largest_count / n) wrong("sizes", "makes more than 2^31 voxels", "crop or resample it");
    count *= n;
  }
  if (header.grid.count() > largest_count) wrong("sizes", "makes more than 2^31 voxels", "crop or resample it");
}

/// Axes in space are "domain" or "space"; the other one a list of anything but colours, tensors and the like.
void Parser::check_kinds() const {
  const std::string* text = find("kinds");
  if (!text) return;
  const auto kinds = words(*text);
  if (kinds.size() != dimension_)
    wrong("kinds", "doesn't name every axis: " + in_quotes(*text), "export the file again");
  for (std::size_t d = 0; d < dimension_; ++d) {
    const std::string kind = lower(kinds[d]);
    const bool unknown = kind == "???" || kind == "none";
    const bool good = list_axis_ == d ? kind == "list" || kind == "scalar" || kind == "vector" || kind == "stub"
                                      : kind == "domain" || kind == "space";
    if (!good && !unknown)
      wrong("kinds",
            "says that axis " + std::to_string(d) + " is " + in_quotes(kind) + ", which is no axis of a plain volume",
            "export one volume with one number a voxel");
  }
}

/// Signs that turn the file's axes into right, anterior, superior.
Eigen::Vector3d Parser::read_signs() const {
  const std::string space = lower(need("space", "left and right are unknown: export it again with its orientation"));
  if (space == "left-posterior-superior" || space == "lps") return {-1, -1, 1};
  if (space == "right-anterior-superior" || space == "ras") return {1, 1, 1};
  if (space == "left-anterior-superior" || space == "las") return {-1, 1, 1};
  wrong("space", "is " + in_quotes(space) + ", which doesn't say where left and right are",
        "export it in left-posterior-superior, right-anterior-superior or left-anterior-superior");
}

double Parser::read_unit() const {
  const std::string* text = find("space units");
  if (!text) return 1e-3;
  std::string_view rest = *text;
  std::optional<double> unit;
  constexpr std::array<std::pair<std::string_view, double>, 4> known{
      {{"\"mm\"", 1e-3}, {"\"m\"", 1}, {"\"cm\"", 1e-2}, {"\"um\"", 1e-6}}};
  for (const std::string_view word : words(rest)) {
    const auto* const at = std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.first == word; });
    if (at == known.end() || (unit && *unit != at->second))
      wrong("space units", "is " + in_quotes(*text), "export it in millimetres");
    unit = at->second;
  }
  return unit.value_or(1e-3);
}

void Parser::read_space(NrrdHeader& header) const {
  const Eigen::Vector3d signs = read_unit() * read_signs();
  std::string_view rest = need("space origin", "export it again with its orientation");
  const auto origin = vector(rest, "space origin");
  if (!origin || !trimmed(rest).empty())
    wrong("space origin", "isn't one vector", "export it again with its orientation");
  header.grid.to_world.translation() = signs.cwiseProduct(*origin);
  int axis = 0;
  for (const auto& direction : directions_)
    if (direction) header.grid.to_world.linear().col(axis++) = signs.cwiseProduct(*direction);
  check_axes(header.grid.to_world, at_line(where_, fields_.at("space directions").line));
}

void Parser::read_numbers(NrrdHeader& header) const {
  using enum ScalarType;
  static const std::map<std::string, ScalarType> types{{"signed char", int8},
                                                       {"int8", int8},
                                                       {"int8_t", int8},
                                                       {"uchar", uint8},
                                                       {"unsigned char", uint8},
                                                       {"uint8", uint8},
                                                       {"uint8_t", uint8},
                                                       {"short", int16},
                                                       {"short int", int16},
                                                       {"signed short", int16},
                                                       {"signed short int", int16},
                                                       {"int16", int16},
                                                       {"int16_t", int16},
                                                       {"ushort", uint16},
                                                       {"unsigned short", uint16},
                                                       {"unsigned short int", uint16},
                                                       {"uint16", uint16},
                                                       {"uint16_t", uint16},
                                                       {"int", int32},
                                                       {"signed int", int32},
                                                       {"int32", int32},
                                                       {"int32_t", int32},
                                                       {"uint", uint32},
                                                       {"unsigned int", uint32},
                                                       {"uint32", uint32},
                                                       {"uint32_t", uint32},
                                                       {"longlong", int64},
                                                       {"long long", int64},
                                                       {"long long int", int64},
                                                       {"signed long long", int64},
                                                       {"signed long long int", int64},
                                                       {"int64", int64},
                                                       {"int64_t", int64},
                                                       {"ulonglong", uint64},
                                                       {"unsigned long long", uint64},
                                                       {"unsigned long long int", uint64},
                                                       {"uint64", uint64},
                                                       {"uint64_t", uint64},
                                                       {"float", float32},
                                                       {"double", float64}};
  const auto type = types.find(lower(need("type", "export the file again")));
  if (type == types.end())
    wrong("type", "is " + in_quotes(*find("type")) + ", which is no type of single numbers", "export the file again");
  header.stored.type = type->second;
  if (bytes_of(header.stored.type) == 1) return;
  const std::string endian = lower(need("endian", "export the file again"));
  if (endian != "little" && endian != "big")
    wrong("endian", "is " + in_quotes(endian) + ", neither little nor big", "export the file again");
  header.stored.swapped = endian == "big";
}

/// A file's name that stays in the folder of the header: nobody's header makes us read what lies elsewhere.
bool stays_beside(const std::string& name) {
  const std::filesystem::path path(name);
  if (name.empty() || path.is_absolute() || name.find('\0') != std::string::npos) return false;
  return std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
}

void Parser::read_data(NrrdHeader& header) const {
  const std::string encoding = lower(need("encoding", "export the file again"));
  header.packed = encoding == "gzip" || encoding == "gz";
  if (!header.packed && encoding != "raw")
    wrong("encoding", "is " + in_quotes(encoding), "export it with the encoding raw or gzip");
  if (find("line skip")) header.line_skip = numbers<std::uint32_t>("line skip", 1)[0];
  if (find("byte skip")) header.byte_skip = numbers<std::int32_t>("byte skip", 1)[0];
  if (header.byte_skip < (header.packed ? 0 : -1))
    wrong("byte skip", "is " + std::to_string(header.byte_skip), "export the file again");
  if (const std::string* file = find("data file")) {
    if (file->starts_with("LIST") || file->find('%') != std::string::npos)
      wrong("data file", "names several files", "export it with one data file");
    if (!stays_beside(*file))
      wrong("data file", "names " + in_quotes(*file) + ", which is not beside the header", "put both into one folder");
    header.data_file = *file;
  }
}

NrrdHeader Parser::header() {
  NrrdHeader header;
  read_axes();
  read_size(header);
  check_kinds();
  read_space(header);
  read_numbers(header);
  read_data(header);
  header.pairs = std::move(pairs_);
  return header;
}

const std::string* pair_of(const NrrdHeader& header, std::size_t segment, const std::string& key) {
  const auto at = header.pairs.find("Segment" + std::to_string(segment) + "_" + key);
  return at == header.pairs.end() ? nullptr : &at->second;
}

[[noreturn]] void bad_segment(const std::string& where, std::size_t segment, const std::string& key,
                              const std::string& value, const std::string& why) {
  throw InputError(where,
                   "its key Segment" + std::to_string(segment) + "_" + key + " is " + in_quotes(value) + ", " + why,
                   "export the segmentation again");
}

std::array<std::int64_t, 6> read_extent(const std::string& text, std::size_t segment, const std::string& where) {
  std::array<std::int64_t, 6> extent{};
  const auto parts = words(text);
  bool good = parts.size() == 6;
  for (std::size_t d = 0; d < 6 && good; ++d) {
    std::int32_t value = 0;
    good = parse_number(parts[d], value);
    extent[d] = value;
  }
  if (!good) bad_segment(where, segment, "Extent", text, "not six whole numbers");
  return extent;
}

NrrdSegment read_segment(const NrrdHeader& header, std::size_t s, const std::string& where) {
  NrrdSegment segment;
  const std::string *name = pair_of(header, s, "Name"), *id = pair_of(header, s, "ID");
  segment.name = name ? *name : id ? *id : std::string();
  const std::string *value = pair_of(header, s, "LabelValue"), *layer = pair_of(header, s, "Layer");
  if (value && (!parse_number(*value, segment.value) || segment.value == 0))
    bad_segment(where, s, "LabelValue", *value, "not a number in 1 … 65535");
  // 3D Slicer before 4.11 wrote one layer a segment, and neither key.
  if (!value && !layer) segment.layer = s;
  if (layer && !parse_number(*layer, segment.layer)) bad_segment(where, s, "Layer", *layer, "not a number");
  if (segment.layer >= header.components)
    bad_segment(where, s, "Layer", std::to_string(segment.layer),
                "but the file has " + std::to_string(header.components) + " of them");
  if (const std::string* extent = pair_of(header, s, "Extent")) segment.extent = read_extent(*extent, s, where);
  return segment;
}

}  // namespace

NrrdHeader parse_nrrd_header(std::string_view text, const std::string& where) {
  return Parser(text, where).header();
}

std::vector<NrrdSegment> nrrd_segments(const NrrdHeader& header, const std::string& where) {
  std::vector<NrrdSegment> segments;
  for (std::size_t s = 0; pair_of(header, s, "ID") || pair_of(header, s, "Name"); ++s) {
    segments.push_back(read_segment(header, s, where));
    const NrrdSegment& last = segments.back();
    for (std::size_t other = 0; other < s; ++other)
      if (segments[other].layer == last.layer && segments[other].value == last.value)
        bad_segment(where, s, "LabelValue", std::to_string(last.value),
                    "the same as segment " + std::to_string(other) + "'s in one layer");
  }
  return segments;
}

}  // namespace calot
