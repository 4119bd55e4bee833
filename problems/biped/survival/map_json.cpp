// The known cells of a survival map as JSON.
#include <charconv>
#include <nlohmann/json.hpp>
#include <string>

#include "problems/biped/survival/map.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;

Json value(const std::string& field) {
  if (field.empty()) return nullptr;
  double number = 0.0;
  const char* end = field.data() + field.size();
  const auto [read, error] = std::from_chars(field.data(), end, number);
  return error == std::errc() && read == end ? Json(number) : Json(field);
}

}  // namespace

std::string map_json(const MapPlan& plan) {
  Json cells = Json::array();
  for (const auto& [cell, row] : plan.rows()) {
    Json& object = cells.emplace_back(Json::object());
    for (const auto& [column, field] : named_fields(row)) object[column] = value(field);
  }
  return cells.dump(2);
}

}  // namespace saltus::robots::walking
