// Inside this room only: JSON files from anywhere, and what is wrong with one.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>

namespace calot::detail {

using Json = nlohmann::ordered_json;

/// Parses a file of any bytes: above `size_limit` bytes, deep nesting and anything but JSON throw InputError naming
/// file and line.
Json read_json(const std::filesystem::path& path, std::uint64_t size_limit);

/// Text with two blanks a level; bytes that aren't UTF-8 become the replacement character instead of an exception.
std::string json_text(const Json& json);

}  // namespace calot::detail
