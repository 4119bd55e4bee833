// Writes JSON member by member, for layers that do not use a JSON library.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// The text as a JSON string, with quotes.
std::string json_string(std::string_view text);
/// The number as JSON. JSON has no NaN and no infinities: they become null.
std::string json_number(double value);

/// An object; members keep their order.
class JsonObject {
 public:
  /// A text.
  JsonObject& text(std::string_view key, std::string_view value);
  /// A number; null if it is not finite or absent.
  JsonObject& number(std::string_view key, const std::optional<double>& value);
  /// An integer.
  JsonObject& integer(std::string_view key, long value);
  /// true or false.
  JsonObject& flag(std::string_view key, bool value);
  /// A value that is already JSON.
  JsonObject& raw(std::string_view key, std::string_view json);

  /// The object on one line.
  std::string str() const;
  /// The object with one line per member and a line break at the end.
  std::string lines() const;

 private:
  std::vector<std::string> members_;
};

/// A JSON list of the results of `to_json` for all items.
template <class Items, class ToJson>
std::string json_list(const Items& items, const ToJson& to_json) {
  std::string list = "[";
  for (const auto& item : items) {
    if (list.size() > 1) list += ", ";
    list += to_json(item);
  }
  list += ']';
  return list;
}

}  // namespace saltus
