// Source: the DICOM standard, part 5, §7 (data elements and sequences), §A (transfer syntaxes), part 10, §7 (files).
#include "calot/image/dicom_elements.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace calot {
namespace {

constexpr std::uint32_t undefined_length = 0xffffffff;
constexpr DicomTag item = 0xfffee000, item_end = 0xfffee00d, sequence_end = 0xfffee0dd;
constexpr int deepest = 40;

struct Element {
  DicomTag tag = 0;
  std::string_view vr;  // empty where it is implicit
  std::uint32_t length = 0;
};

/// Steps through elements; every step says whether the bytes sufficed.
class Walker {
 public:
  Walker(std::string_view bytes, bool big_endian, bool implicit)
      : bytes_(bytes), big_endian_(big_endian), implicit_(implicit) {}

  [[nodiscard]] bool at_end() const { return bytes_.empty(); }
  [[nodiscard]] std::string_view rest() const { return bytes_; }

  bool next(Element& element) {
    std::uint16_t group = 0, number = 0;
    if (!take(group) || !take(number)) return false;
    element.tag = DicomTag{group} << 16 | number;
    element.vr = {};
    if (implicit_ || group == 0xfffe) return take(element.length);
    if (!take(2, element.vr) || !std::all_of(element.vr.begin(), element.vr.end(), is_capital)) return false;
    static constexpr std::string_view long_ones = "OB OD OF OL OV OW SQ SV UC UN UR UT UV ";
    if (long_ones.find(std::string(element.vr) + " ") != std::string_view::npos) {
      std::string_view reserved;
      return take(2, reserved) && take(element.length);
    }
    std::uint16_t length = 0;
    if (!take(length)) return false;
    element.length = length;
    return true;
  }

  bool take(std::size_t count, std::string_view& piece) {
    if (bytes_.size() < count) return false;
    piece = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return true;
  }

  /// Passes over the value of an element, whatever is nested in it.
  bool pass(const Element& element, int depth = 0) {
    std::string_view passed;
    if (element.length != undefined_length) return take(element.length, passed);
    if (depth > deepest) return false;
    // An unknown element of undefined length is a sequence in the implicit form.
    Walker inner(bytes_, big_endian_, implicit_ || element.vr == "UN");
    if (!inner.pass_items(depth)) return false;
    bytes_ = inner.bytes_;
    return true;
  }

  /// The pieces of compressed pixels, without the table of offsets that comes first.
  bool take_fragments(std::vector<std::string_view>& fragments) {
    Element piece;
    for (bool first = true; next(piece); first = false) {
      if (piece.tag == sequence_end) return true;
      std::string_view bytes;
      if (piece.tag != item || piece.length == undefined_length || !take(piece.length, bytes)) return false;
      if (!first) fragments.push_back(bytes);
    }
    return false;
  }

 private:
  static bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }

  template <class T>
  bool take(T& value) {
    std::string_view raw;
    if (!take(sizeof(T), raw)) return false;
    value = 0;
    for (std::size_t b = 0; b < sizeof(T); ++b) {
      const auto byte = static_cast<unsigned char>(raw[big_endian_ ? b : sizeof(T) - 1 - b]);
      value = static_cast<T>(value << 8 | byte);
    }
    return true;
  }

  bool pass_items(int depth) {
    Element part;
    while (next(part)) {
      if (part.tag == sequence_end) return true;
      if (part.tag != item) return false;
      if (part.length != undefined_length ? !pass(part) : !pass_item_content(depth)) return false;
    }
    return false;
  }

  bool pass_item_content(int depth) {
    Element inside;
    while (next(inside)) {
      if (inside.tag == item_end) return true;
      if (!pass(inside, depth + 1)) return false;
    }
    return false;
  }

  std::string_view bytes_;
  bool big_endian_, implicit_;
};

std::string trimmed(std::string_view text) {
  constexpr std::string_view blank(" \0\t", 3);
  const auto begin = text.find_first_not_of(blank);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(blank) - begin + 1));
}

/// The elements of group 2, which tell how the others are written; leaves `bytes` behind them.
bool read_meta(std::string_view& bytes, DicomData& data) {
  while (bytes.size() >= 2 && bytes[0] == 2 && bytes[1] == 0) {
    Walker walker(bytes, false, false);
    Element element;
    std::string_view value;
    if (!walker.next(element) || element.length == undefined_length || !walker.take(element.length, value))
      return false;
    data.elements[element.tag] = value;
    bytes = walker.rest();
  }
  data.transfer_syntax = data.text(0x00020010);
  return true;
}

bool read_elements(Walker& walker, DicomData& data, bool only_header) {
  Element element;
  while (!walker.at_end()) {
    if (!walker.next(element)) return false;
    if (element.tag == dicom_pixel_data) {
      data.has_pixels = true;
      if (only_header) return true;
      return element.length == undefined_length ? walker.take_fragments(data.fragments)
                                                : walker.take(element.length, data.pixels);
    }
    if (only_header && element.tag > dicom_pixel_data) return true;
    std::string_view value;
    if (element.length == undefined_length ? !walker.pass(element) : !walker.take(element.length, value)) return false;
    data.elements.emplace(element.tag, value);
  }
  return true;
}

}  // namespace

std::string DicomData::text(DicomTag tag) const {
  const auto at = elements.find(tag);
  return at == elements.end() ? std::string() : trimmed(at->second);
}

std::vector<double> DicomData::numbers(DicomTag tag) const {
  const std::string all = text(tag);
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = std::min(all.find('\\', begin), all.size());
    std::string word = trimmed(std::string_view(all).substr(begin, end - begin));
    if (word.starts_with('+')) word.erase(0, 1);
    double value = 0;
    const auto [stop, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc() || stop != word.data() + word.size() || !std::isfinite(value)) break;
    numbers.push_back(value);
    begin = end + 1;
  }
  return numbers;
}

int DicomData::short_number(DicomTag tag, int otherwise) const {
  const auto at = elements.find(tag);
  if (at == elements.end() || at->second.size() < 2) return otherwise;
  const auto first = static_cast<unsigned char>(at->second[0]), second = static_cast<unsigned char>(at->second[1]);
  return big_endian ? first << 8 | second : second << 8 | first;
}

bool has_dicom_mark(std::string_view bytes) {
  return bytes.size() >= 132 && bytes.substr(128, 4) == "DICM";
}

std::optional<DicomData> parse_dicom(std::string_view bytes, bool only_header) {
  const bool marked = has_dicom_mark(bytes);
  if (marked) bytes.remove_prefix(132);
  DicomData data;
  if (!read_meta(bytes, data)) return {};
  bool implicit = data.transfer_syntax == "1.2.840.10008.1.2";
  if (data.transfer_syntax.empty()) {  // an old file without the first part: it begins with group 8
    if (bytes.size() < 8 || bytes[0] != 8 || bytes[1] != 0) return {};
    implicit = !(bytes[4] >= 'A' && bytes[4] <= 'Z' && bytes[5] >= 'A' && bytes[5] <= 'Z');
    data.transfer_syntax = implicit ? "1.2.840.10008.1.2" : "1.2.840.10008.1.2.1";
  }
  data.big_endian = data.transfer_syntax == "1.2.840.10008.1.2.2";
  if (data.transfer_syntax == "1.2.840.10008.1.2.1.99") return data;  // deflated: nothing to be seen
  Walker walker(bytes, data.big_endian, implicit);
  if (!read_elements(walker, data, only_header)) return {};
  return data;
}

}  // namespace calot
