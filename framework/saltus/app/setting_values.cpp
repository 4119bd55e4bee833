// Values of single settings: parsed from text, checked, assigned and written back.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>

#include "saltus/app/overloaded.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

// "'push.impulse' must be a number (N s), not 'abc'", preceded by the location.
[[noreturn]] void reject(const Assignment& given, const std::string& key, const std::string& what) {
  std::string shown;
  for (const std::string& item : given.items) shown += (shown.empty() ? "" : ", ") + item;
  if (given.form == Assignment::Form::list) shown = "[" + shown + "]";
  if (given.form == Assignment::Form::none || shown.empty()) {
    throw InputError(
        fmt::format("{}: '{}' must be {}, but has no value", given.location, key, what));
  }
  throw InputError(
      fmt::format("{}: '{}' must be {}, not '{}'", given.location, key, what, shortened(shown)));
}

// YAML's spelling of NaN and infinity is accepted as a number here and then rejected as not finite.
std::string_view without_yaml_dot(std::string_view text) {
  const bool negative = text.starts_with('-');
  const std::string_view word = negative ? text.substr(1) : text;
  if (word == ".inf" || word == ".Inf" || word == ".INF") return negative ? "-inf" : "inf";
  if (word == ".nan" || word == ".NaN" || word == ".NAN") return "nan";
  return text;
}

struct ParsedNumber {
  bool is_number = false;
  double value = 0.0;
};

ParsedNumber parse_number(std::string_view text) {
  text = without_yaml_dot(text);
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return {};
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || text.empty()) return {};
  // The number is too large, or too small to distinguish from 0.
  if (error == std::errc::result_out_of_range) {
    return {true, std::strtod(std::string(text).c_str(), nullptr)};
  }
  return {error == std::errc{}, value};
}

double checked_number(const std::string& text, const Assignment& given, const std::string& key,
                      const std::string& unit, const Range& range) {
  const ParsedNumber number = parse_number(text);
  if (!number.is_number) {
    reject(given, key, unit.empty() ? "a number" : fmt::format("a number ({})", unit));
  }
  if (!std::isfinite(number.value)) reject(given, key, "a finite number");
  if (!range.contains(number.value)) reject(given, key, range.text(unit));
  return number.value;
}

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = text.find(',', begin);
    std::string part = text.substr(begin, comma - begin);
    const auto first = part.find_first_not_of(' ');
    const auto last = part.find_last_not_of(' ');
    parts.push_back(first == std::string::npos ? "" : part.substr(first, last - first + 1));
    if (comma == std::string::npos) return parts;
    begin = comma + 1;
  }
}

// The shortest text that gives the same number when read back, such as "1.0e-08". Without the dot,
// YAML 1.1 parsers would read a string.
std::string number_text(double number) {
  std::string text = fmt::format("{}", number);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos)
    text.insert(exponent, ".0");
  return text;
}

// Quoted as in JSON, which is valid YAML: no text can be mistaken for another type.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::string Range::text(const std::string& unit) const {
  std::string text;
  if (lower != -infinity) text = fmt::format("{} {}", lower_excluded ? "above" : "at least", lower);
  if (upper != infinity) {
    text += text.empty() ? "" : " and ";
    text += fmt::format("{} {}", upper_excluded ? "below" : "at most", upper);
  }
  return text.empty() || unit.empty() ? text : text + " " + unit;
}

Settings::Value Settings::current_value(const Setting& setting) {
  return std::visit(
      Overloaded{[](const auto* field) -> Value { return *field; },
                 [](const std::span<double>& field) -> Value {
                   return std::vector<double>(field.begin(), field.end());
                 },
                 [](const ChoiceField& field) -> Value { return field.index().value_or(0); }},
      setting.field);
}

Settings::Value Settings::parse(const Setting& setting, const Assignment& given) {
  using Form = Assignment::Form;
  const std::string& key = setting.key;
  const std::string scalar = given.form == Form::scalar ? given.items.at(0) : "";

  const auto number = [&](const std::string& text) {
    return checked_number(text, given, key, setting.unit, setting.range);
  };
  const auto parse_integer = [&]() -> int {
    int value = 0;
    const std::string_view text =
        scalar.starts_with('+') ? std::string_view(scalar).substr(1) : std::string_view(scalar);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || end != text.data() + text.size() || error == std::errc::invalid_argument) {
      reject(given, key, "a whole number");
    }
    if (error == std::errc::result_out_of_range) {
      constexpr int least = std::numeric_limits<int>::min(), most = std::numeric_limits<int>::max();
      reject(given, key,
             setting.range.is_free() ? fmt::format("a whole number from {} to {}", least, most)
                                     : fmt::format("{}, and a whole number of at most {}",
                                                   setting.range.text(setting.unit), most));
    }
    if (!setting.range.contains(value)) reject(given, key, setting.range.text(setting.unit));
    return value;
  };
  const auto parse_flag = [&]() -> bool {
    if (given.form == Form::none && given.origin == Assignment::Origin::flag) return true;
    if (scalar == "true") return true;
    if (scalar == "false") return false;
    reject(given, key, "true or false");
  };
  const auto parse_vector = [&](std::size_t size) {
    std::vector<std::string> items = given.items;
    if (given.form == Form::scalar) items = split_at_commas(scalar);
    if (given.form == Form::none || items.size() != size) {
      reject(given, key, fmt::format("a list of {} numbers", size));
    }
    std::vector<double> values;
    values.reserve(size);
    for (const std::string& item : items) values.push_back(number(item));
    return values;
  };
  const auto parse_choice = [&]() -> std::size_t {
    const auto it = std::find(setting.names.begin(), setting.names.end(), scalar);
    if (it != setting.names.end()) return static_cast<std::size_t>(it - setting.names.begin());
    const std::string meant = nearest_name(scalar, setting.names);
    if (scalar.empty() || meant.empty()) reject(given, key, allowed_text(setting));
    throw InputError(fmt::format("{}: '{}' must be {}, not '{}'; did you mean '{}'?",
                                 given.location, key, allowed_text(setting), shortened(scalar),
                                 meant));
  };
  const auto parse_text = [&]() -> std::string {
    if (given.form != Form::scalar) reject(given, key, "a text");
    return std::string(scalar);
  };
  const auto parse_optional = [&]() -> std::optional<double> {
    if (scalar == "none") return std::nullopt;
    return number(scalar);
  };

  return std::visit(
      Overloaded{
          [&](const double*) -> Value { return number(scalar); },
          [&](const std::optional<double>*) -> Value { return parse_optional(); },
          [&](const int*) -> Value { return parse_integer(); },
          [&](const bool*) -> Value { return parse_flag(); },
          [&](const std::string*) -> Value { return parse_text(); },
          [&](const std::span<double>& field) -> Value { return parse_vector(field.size()); },
          [&](const ChoiceField&) -> Value { return parse_choice(); }},
      setting.field);
}

void Settings::assign(const Setting& setting, const Value& value) {
  std::visit(
      Overloaded{
          [&](double* field) { *field = std::get<double>(value); },
          [&](std::optional<double>* field) { *field = std::get<std::optional<double>>(value); },
          [&](int* field) { *field = std::get<int>(value); },
          [&](bool* field) { *field = std::get<bool>(value); },
          [&](std::string* field) { *field = std::get<std::string>(value); },
          [&](const std::span<double>& field) {
            const auto& numbers = std::get<std::vector<double>>(value);
            std::copy(numbers.begin(), numbers.end(), field.begin());
          },
          [&](const ChoiceField& field) { field.assign(std::get<std::size_t>(value)); }},
      setting.field);
}

std::string Settings::yaml_text(const Setting& setting, const Value& value) {
  return std::visit(Overloaded{[](double number) { return number_text(number); },
                               [](const std::optional<double>& number) {
                                 return number ? number_text(*number) : std::string("none");
                               },
                               [](int number) { return fmt::format("{}", number); },
                               [](bool flag) { return std::string(flag ? "true" : "false"); },
                               [](const std::string& text) { return quoted(text); },
                               [](const std::vector<double>& numbers) {
                                 std::string text;
                                 for (const double number : numbers) {
                                   text += (text.empty() ? "" : ", ") + number_text(number);
                                 }
                                 return "[" + text + "]";
                               },
                               [&](std::size_t index) { return setting.names.at(index); }},
                    value);
}

std::string Settings::allowed_text(const Setting& setting) {
  if (std::holds_alternative<bool*>(setting.field)) return "true or false";
  if (!setting.names.empty()) {
    std::string text;
    for (std::size_t i = 0; i < setting.names.size(); ++i) {
      if (i > 0) text += i + 1 == setting.names.size() ? " or " : ", ";
      text += setting.names[i];
    }
    return text;
  }
  return setting.range.text();
}

}  // namespace saltus
