#include "calot/mesh/cursor.h"

namespace calot::detail {
namespace {
bool is_space(char c) {
  return c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}
}  // namespace

std::string in_quotes(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, 40)) shown += c >= ' ' && c <= '~' ? c : '?';
  return "\"" + shown + (text.size() > 40 ? "…\"" : "\"");
}

std::string Cursor::where() const {
  std::string place = name_;
  if (binary_) {
    place += ": byte " + std::to_string(item_);
  } else {
    const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(item_);
    place = at_line(name_, first_line_ + static_cast<std::size_t>(std::count(bytes_.begin(), end, '\n')));
  }
  return section_.empty() ? place : place + ": in " + section_;
}

void Cursor::fail(const std::string& what, const std::string& what_to_do) const {
  throw InputError(where(), what,
                   what_to_do.empty() ? "the file is damaged or cut short; export it again" : what_to_do);
}

bool Cursor::skip_space() {
  while (position_ < bytes_.size() && is_space(bytes_[position_])) ++position_;
  return !at_end();
}

std::string_view Cursor::token(const char* what) {
  const bool more = skip_space();
  item_ = position_;
  if (!more) fail(std::string("the file ends where ") + what + " should follow");
  while (position_ < bytes_.size() && !is_space(bytes_[position_])) ++position_;
  return bytes_.substr(item_, position_ - item_);
}

std::string_view Cursor::token_on_line() {
  while (position_ < bytes_.size() && is_space(bytes_[position_]) && bytes_[position_] != '\n') ++position_;
  if (at_end() || bytes_[position_] == '\n') return {};
  return token("a word");
}

std::string_view Cursor::rest_of_line() {
  item_ = position_;
  const std::size_t end = std::min(bytes_.find('\n', position_), bytes_.size());
  std::string_view line = bytes_.substr(position_, end - position_);
  position_ = std::min(end + 1, bytes_.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

bool Cursor::skip_past(std::string_view text) {
  const std::size_t found = bytes_.find(text, position_);
  if (found == std::string_view::npos) return false;
  position_ = found + text.size();
  return true;
}

std::string_view Cursor::take(std::size_t size, const char* what) {
  item_ = position_;
  if (size > remaining())
    fail(std::string("the file ends within ") + what + ": " + std::to_string(size) + " bytes needed, " +
         std::to_string(remaining()) + " left");
  position_ += size;
  return bytes_.substr(item_, size);
}

std::size_t Cursor::checked_count(std::uint64_t count, std::size_t bytes_each, const char* what) const {
  const std::size_t separator = binary_ ? 0 : 1;
  if (count > (remaining() + separator) / std::max<std::size_t>(bytes_each, 1))
    fail(std::to_string(count) + " " + what + " can't fit in the " + std::to_string(remaining()) +
         " bytes that are left");
  return static_cast<std::size_t>(count);
}

}  // namespace calot::detail
