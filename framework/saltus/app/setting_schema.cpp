// Documentation of settings: comments for readers, a JSON Schema for editors.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "saltus/app/overloaded.hpp"
#include "saltus/app/settings.hpp"

namespace saltus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t widest_line = 100;

// Wraps a text into lines, each after "# ".
std::string comment(const std::string& text, std::size_t indentation) {
  std::string lines, line;
  const auto end_line = [&] {
    if (!line.empty()) lines += std::string(indentation, ' ') + "#" + line + "\n";
    line.clear();
  };
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t space = std::min(text.find_first_of(" \n", begin), text.size());
    const std::string word = text.substr(begin, space - begin);
    if (!line.empty() && indentation + line.size() + word.size() + 2 > widest_line) end_line();
    if (!word.empty()) line += " " + word;
    begin = space + 1;
  }
  end_line();
  return lines;
}

Json number_schema(const char* type, const Range& range) {
  Json schema{{"type", type}};
  if (std::isfinite(range.lower))
    schema[range.lower_excluded ? "exclusiveMinimum" : "minimum"] = range.lower;
  if (std::isfinite(range.upper))
    schema[range.upper_excluded ? "exclusiveMaximum" : "maximum"] = range.upper;
  return schema;
}

// The object that contains the key; created if it does not exist.
Json& section_of(Json& schema, const std::string& key) {
  Json* section = &schema;
  std::size_t begin = 0;
  for (std::size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', begin)) {
    Json& next = (*section)["properties"][key.substr(begin, dot - begin)];
    if (next.is_null())
      next = {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
    section = &next;
    begin = dot + 1;
  }
  return *section;
}

}  // namespace

std::string Settings::documentation(const Setting& setting, std::size_t indentation) {
  std::string facts = setting.unit;
  const auto add = [&facts](const std::string& text) {
    if (!text.empty()) facts += (facts.empty() ? "" : "; ") + text;
  };
  add(allowed_text(setting));
  add("default " + setting.default_text);
  return comment(fmt::format("{} [{}]", setting.doc, facts), indentation);
}

std::string Settings::json_schema(const std::string& title) const {
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
              {"title", title},
              {"type", "object"},
              {"additionalProperties", false},
              {"properties", Json::object()}};
  const auto value_schema = [](const Setting& s) -> Json {
    if (!s.names.empty()) return {{"enum", s.names}};
    return std::visit(
        Overloaded{
            [&](const double*) { return number_schema("number", s.range); },
            [&](const std::optional<double>*) {
              return Json{{"anyOf", {number_schema("number", s.range), {{"const", "none"}}}}};
            },
            [&](const int*) { return number_schema("integer", s.range); },
            [](const bool*) {
              return Json{{"type", "boolean"}};
            },
            [](const std::string*) {
              return Json{{"type", "string"}};
            },
            [&](const std::span<double>& numbers) {
              return Json{{"type", "array"},
                          {"items", number_schema("number", s.range)},
                          {"minItems", numbers.size()},
                          {"maxItems", numbers.size()}};
            },
            [](const ChoiceField&) { return Json::object(); }},
        s.field);
  };
  const auto add = [&](const std::string& key, const Setting& setting, const Json& more) {
    Json value = value_schema(setting);
    value["description"] =
        setting.unit.empty() ? setting.doc : fmt::format("{} [{}]", setting.doc, setting.unit);
    const Json parsed = Json::parse(setting.default_text, nullptr, /*allow_exceptions=*/false);
    value["default"] = parsed.is_discarded() ? Json(setting.default_text) : parsed;
    value.update(more);
    const std::size_t dot = key.rfind('.');
    section_of(schema, key)["properties"][dot == std::string::npos ? key : key.substr(dot + 1)] =
        value;
  };
  for (const Setting& setting : settings_) add(setting.key, setting, Json::object());
  for (const Renamed& old : renamed_)
    if (const Setting* setting = find(old.key, Assignment::Origin::set))
      add(old.old_key, *setting,
          {{"deprecated", true}, {"description", fmt::format("is now called '{}'", old.key)}});
  for (const Removed& old : removed_) {
    const std::size_t dot = old.key.rfind('.');
    section_of(
        schema,
        old.key)["properties"][dot == std::string::npos ? old.key : old.key.substr(dot + 1)] = {
        {"deprecated", true}, {"description", "is always " + old.value}};
  }
  return schema.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace saltus
