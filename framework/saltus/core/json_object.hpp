// JSON that is written member by member, for the layers that do without a library of JSON.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// The text as a string of JSON, with its quotes.
std::string json_string(std::string_view text);
/// The number as JSON. JSON has no word for NaN and infinities: null.
std::string json_number(double value);

/// An object; members keep their order.
class JsonObject {
 public:
  /// A text.
  JsonObject& text(std::string_view key, std::string_view value);
  /// A number; null if it is not finite or absent.
  JsonObject& number(std::string_view key, const std::optional<double>& value);
  /// A whole number.
  JsonObject& integer(std::string_view key, long value);
  /// true or false.
  JsonObject& flag(std::string_view key, bool value);
  /// A value that is JSON already.
  JsonObject& raw(std::string_view key, std::string_view json);

  /// The object in one line.
  std::string str() const;
  /// The object with one line per member and a line break at the end.
  std::string lines() const;

 private:
  std::vector<std::string> members_;
};

/// A list of what `to_json` makes of each item.
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
