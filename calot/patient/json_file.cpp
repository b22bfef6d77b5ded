#include "calot/patient/json_file.h"

#include <algorithm>

#include "calot/base/error.h"
#include "calot/base/files.h"

namespace calot::detail {
namespace {

constexpr int nesting_limit = 64;

void check_depth(const std::string& bytes, const std::string& file) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char c = bytes[i];
    if (c == '"') quoted = !quoted;
    if (quoted && c == '\\') ++i;
    if (quoted) continue;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > nesting_limit) throw InputError(file, "is nested too deeply", "check its brackets");
  }
}

std::size_t line_of(const std::string& bytes, std::size_t byte) {
  const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(byte, bytes.size()));
  return 1 + static_cast<std::size_t>(std::count(bytes.begin(), end, '\n'));
}

/// The library's message without its own numbering: "[json.exception.parse_error.101] parse error at line 1 …: what".
std::string plain_reason(const std::string& message) {
  std::string text = message.substr(0, message.find('\n'));
  if (const auto place = text.find("] "); text.starts_with('[') && place != std::string::npos) text.erase(0, place + 2);
  if (const auto place = text.find(": "); text.starts_with("parse error at") && place != std::string::npos)
    text.erase(0, place + 2);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return text.substr(0, 160);
}

}  // namespace

Json read_json(const std::filesystem::path& path, std::uint64_t size_limit) {
  const std::string bytes = read_file(path, size_limit);
  check_depth(bytes, path.string());
  try {
    return Json::parse(bytes);
  } catch (const Json::parse_error& wrong) {
    throw InputError(at_line(path.string(), line_of(bytes, wrong.byte)), "not JSON: " + plain_reason(wrong.what()),
                     "check the file, or write it again with the program that made it");
  } catch (const Json::exception& wrong) {
    throw InputError(path.string(), "not JSON: " + plain_reason(wrong.what()),
                     "check the file, or write it again with the program that made it");
  }
}

std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace calot::detail
