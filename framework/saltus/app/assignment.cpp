#include "saltus/app/settings.hpp"

#include <fmt/format.h>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/yaml/yaml_section.hpp"

namespace saltus {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space = " \t\r\n";
  const auto first = text.find_first_not_of(space);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(space) - first + 1);
}

// Nested sections become dotted keys. An empty section is a key without a value.
void flatten(const std::vector<YamlEntry>& entries, const std::string& prefix,
             const std::string& file, std::vector<Assignment>& list) {
  for (const YamlEntry& entry : entries) {
    if (!entry.entries.empty()) {
      flatten(entry.entries, prefix + entry.key + ".", file, list);
      continue;
    }
    Assignment assignment;
    assignment.key = prefix + entry.key;
    assignment.origin = Assignment::Origin::file;
    assignment.location = fmt::format("{}:{}", file, entry.line);
    if (entry.form == YamlEntry::Form::scalar) assignment.form = Assignment::Form::scalar;
    if (entry.form == YamlEntry::Form::list) assignment.form = Assignment::Form::list;
    assignment.items = entry.items;
    list.push_back(std::move(assignment));
  }
}

Assignment from_text(std::string_view key, std::string_view value) {
  Assignment assignment;
  assignment.key = std::string(trimmed(key));
  std::string_view text = trimmed(value);
  if (text.size() >= 2 && text.front() == '[' && text.back() == ']') {
    assignment.form = Assignment::Form::list;
    text = trimmed(text.substr(1, text.size() - 2));
    while (!text.empty()) {
      const auto comma = text.find(',');
      assignment.items.emplace_back(trimmed(text.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      text.remove_prefix(comma + 1);
      if (text.empty()) assignment.items.emplace_back();  // a trailing comma
    }
  } else {
    assignment.form = Assignment::Form::scalar;
    assignment.items = {std::string(text)};
  }
  return assignment;
}

}  // namespace

std::vector<Assignment> read_assignments(const std::filesystem::path& file) {
  const YamlEntry root = read_yaml(file);
  if (root.entries.empty())
    throw InputError(fmt::format("{}: the file contains no settings", file.string()));
  std::vector<Assignment> list;
  flatten(root.entries, "", file.string(), list);
  return list;
}

Assignment parse_set_argument(std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos || trimmed(text.substr(0, equals)).empty()) {
    throw InputError(fmt::format("--set {}: expected KEY=VALUE", shortened(text)));
  }
  Assignment assignment = from_text(text.substr(0, equals), text.substr(equals + 1));
  assignment.origin = Assignment::Origin::set;
  assignment.location = fmt::format("--set {}", shortened(text));
  return assignment;
}

Assignment flag_assignment(std::string_view flag, std::string_view value) {
  Assignment assignment = from_text(flag, value);
  assignment.origin = Assignment::Origin::flag;
  assignment.location = fmt::format("--{}", flag);
  return assignment;
}

Assignment bare_flag_assignment(std::string_view flag) {
  Assignment assignment;
  assignment.key = std::string(flag);
  assignment.origin = Assignment::Origin::flag;
  assignment.location = fmt::format("--{}", flag);
  return assignment;
}

}  // namespace saltus
