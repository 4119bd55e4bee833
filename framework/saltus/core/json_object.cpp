#include "saltus/core/json_object.hpp"

#include <fmt/format.h>

#include <cmath>

namespace saltus {

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + '"';
}

std::string json_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string("null");
}

JsonObject& JsonObject::text(std::string_view key, std::string_view value) {
  return raw(key, json_string(value));
}

JsonObject& JsonObject::number(std::string_view key, const std::optional<double>& value) {
  return raw(key, value ? json_number(*value) : "null");
}

JsonObject& JsonObject::integer(std::string_view key, long value) {
  return raw(key, fmt::format("{}", value));
}

JsonObject& JsonObject::flag(std::string_view key, bool value) {
  return raw(key, value ? "true" : "false");
}

JsonObject& JsonObject::raw(std::string_view key, std::string_view json) {
  members_.push_back(fmt::format("{}: {}", json_string(key), json));
  return *this;
}

std::string JsonObject::str() const { return fmt::format("{{{}}}", fmt::join(members_, ", ")); }

std::string JsonObject::lines() const {
  return fmt::format("{{\n  {}\n}}\n", fmt::join(members_, ",\n  "));
}

}  // namespace saltus
