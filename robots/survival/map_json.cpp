// What is known of a survival map, for programs to read.
#include <charconv>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "saltus/robots/survival/map.hpp"

namespace saltus::walking {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> fields(std::string_view line) {
  std::vector<std::string> list{""};
  for (const char c : line) {
    if (c == ',')
      list.emplace_back();
    else
      list.back() += c;
  }
  return list;
}

Json value(const std::string& field) {
  if (field.empty()) return nullptr;
  double number = 0.0;
  const char* end = field.data() + field.size();
  const auto [read, error] = std::from_chars(field.data(), end, number);
  return error == std::errc() && read == end ? Json(number) : Json(field);
}

}  // namespace

std::string map_json(const MapPlan& plan) {
  const std::vector<std::string> names = fields(map_header());
  Json cells = Json::array();
  for (const auto& [cell, row] : plan.rows()) {
    const std::vector<std::string> values = fields(to_line(row));
    Json& object = cells.emplace_back(Json::object());
    for (std::size_t i = 0; i < names.size(); ++i) object[names[i]] = value(values[i]);
  }
  return cells.dump(2);
}

}  // namespace saltus::walking
