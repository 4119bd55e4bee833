// Settings of a program: named keys whose text values are converted to fields of plain structs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

// One "key = value" from a file or the command line, with its source.

/// A value as written. `Settings` converts it to the type of its key.
struct Assignment {
  /// Source of the text: a file, --set, or a flag.
  enum class Origin { file, set, flag };
  enum class Form { scalar, list, none };  ///< `none`: a key without a value

  std::string key;                 ///< dotted, as written: "push.impulse"
  Form form = Form::none;          ///< how the value was written
  std::vector<std::string> items;  ///< one entry for a scalar, any number for a list
  Origin origin = Origin::set;     ///< source
  std::string location;  ///< source for messages: "push.yaml:3", "--set push.impulse=7", "--urdf"
};

/// Reads the settings of a YAML file, in the order of the file. Nested maps become dotted keys.
/// Throws InputError as `read_yaml` does, and if the file has no setting.
std::vector<Assignment> read_assignments(const std::filesystem::path& file);

/// Parses the "KEY=VALUE" of --set. Lists are written [a, b, c] or a,b,c. Throws InputError if the
/// '=' or the key is missing.
Assignment parse_set_argument(std::string_view text);

/// The assignment of a flag: `--urdf robot.urdf` means `--set urdf=robot.urdf`.
Assignment flag_assignment(std::string_view flag, std::string_view value);

/// A flag without a value (`--stepping`), which only boolean settings accept.
Assignment bare_flag_assignment(std::string_view flag);

// Range of numbers that a setting accepts; its ends may be excluded.

/// An interval of allowed numbers. Ranges from `Bounds` (`at_least(0)`, `between(0, 1)`) include
/// their ends; those from `above`, `below` or `strictly_between` do not.
struct Range {
  double lower = -infinity;     ///< smallest allowed number
  double upper = infinity;      ///< largest allowed number
  bool lower_excluded = false;  ///< `lower` itself is not allowed
  bool upper_excluded = false;  ///< `upper` itself is not allowed

  Range() = default;
  /// Range with both ends included.
  Range(const Bounds& bounds) : lower(bounds.lower), upper(bounds.upper) {}  // NOLINT: intended

  /// False for NaN.
  bool contains(double value) const {
    const bool low_enough = upper_excluded ? value < upper : value <= upper;
    const bool high_enough = lower_excluded ? value > lower : value >= lower;
    return low_enough && high_enough;
  }
  /// True if every number is allowed.
  bool is_free() const { return lower == -infinity && upper == infinity; }

  /// Text for messages: "at least 0 N s", "above 0 and at most 1"; empty if every number is
  /// allowed.
  std::string text(const std::string& unit = "") const;
};

/// Numbers greater than `lower`.
inline Range above(double lower) {
  Range range{at_least(lower)};
  range.lower_excluded = true;
  return range;
}

/// Numbers less than `upper`.
inline Range below(double upper) {
  Range range{at_most(upper)};
  range.upper_excluded = true;
  return range;
}

/// Numbers greater than `lower` and less than `upper`.
inline Range strictly_between(double lower, double upper) {
  Range range{between(lower, upper)};
  range.lower_excluded = range.upper_excluded = true;
  return range;
}

/// A registry of keys, each bound to a field of a struct that must outlive the registry. The value
/// of the field at its declaration is the default.
///
///     PushConfig config;
///     Settings settings;
///     settings.number("push.impulse", config.push.impulse, "N s", "size of push", at_least(0));
///     settings.flag("stepping", config.stepping, "may the robot step?");
///     settings.apply("push.yaml", {parse_set_argument("push.impulse=8")});
///
/// Errors of declarations throw DefinitionError: a repeated key, or a default outside its range.
/// Errors of user input throw InputError: one sentence with location, key, value and remedy. All
/// fields are then unchanged.
class Settings {
 public:
  /// A finite number. `unit` is for documentation ("" for none).
  void number(std::string key, double& field, std::string unit, std::string doc, Range range = {});
  /// A finite number or "none".
  void number(std::string key, std::optional<double>& field, std::string unit, std::string doc,
              Range range = {});
  /// An integer.
  void integer(std::string key, int& field, std::string unit, std::string doc, Range range = {});
  /// A boolean, true or false.
  void flag(std::string key, bool& field, std::string doc);
  /// A text, such as a file name.
  void text(std::string key, std::string& field, std::string doc);
  /// A list of exactly field.size() numbers within `range`.
  void vector(std::string key, VectorOut field, std::string unit, std::string doc,
              Range range = {});
  /// One of several names.
  void choice(std::string key, std::string& field, std::vector<std::string> names, std::string doc);
  /// One of several names, each with an enumerator.
  template <class Enum>
  void choice(std::string key, Enum& field, std::vector<std::pair<std::string, Enum>> named_values,
              std::string doc);

  /// A choice that sets several fields: `index` returns the current name, `assign` sets the fields.
  void choice(std::string key, std::vector<std::string> names,
              std::function<std::optional<std::size_t>()> index,
              std::function<void(std::size_t)> assign, std::string doc);

  /// Makes these names of the choice `key` a preset: a list of values of other settings, each
  /// "KEY=VALUE" as in --set. All keys must already be declared.
  ///
  /// The values apply if apply() receives one of the names. Keys that apply() receives override
  /// all presets, and later presets override earlier ones. A preset never triggers another one.
  /// Help lists the values, and to_yaml() writes the current ones.
  void preset(const std::string& key, const std::vector<std::string>& names,
              const std::vector<std::string>& values);

  /// A preset as in 0.2.
  struct Preset {
    std::string name;                 ///< name in the settings
    std::vector<std::string> values;  ///< each "KEY=VALUE"
  };
  /// Declares a key that selects one of the presets, as in 0.2.
  [[deprecated("use choice() and preset(key, names, values); removed in 0.4")]] void preset(
      std::string key, std::string& field, const std::vector<Preset>& presets, std::string doc);

  /// Makes a command-line flag an alias of a key: alias("urdf", "robot.urdf").
  void alias(std::string flag, const std::string& key);

  /// A key that had another name. The old name is accepted until `version`, with a warning.
  void renamed(std::string old_key, const std::string& key, std::string version);
  /// A key that no longer exists, with the value that is now fixed. Until `version`, files and
  /// commands that give this value are accepted with a warning. Other values are refused.
  void removed(std::string old_key, std::string value, std::string version);
  /// Rewrites assignments of older versions before they are read: those of the file and those of
  /// the command line. Returns a warning for each assignment that it replaced.
  using Translation = std::function<std::vector<std::string>(
      std::vector<Assignment>& file, std::vector<Assignment>& command_line)>;
  /// Sets the translation of old assignments.
  void translate(Translation translation) { translation_ = std::move(translation); }

  /// A condition on several settings, checked after all are set. `complaint` returns an error
  /// ("contact.fz_min (50) exceeds contact.fz_max (20)") or an empty string. The message starts
  /// with the location that set one of `keys` last.
  void rule(std::vector<std::string> keys, std::function<std::string()> complaint);

  /// Applies the file, if any, then the assignments, which override it. Applies everything or
  /// nothing.
  void apply(const std::optional<std::filesystem::path>& file,
             const std::vector<Assignment>& assignments);
  /// Applies assignments only. A repeated key is an error.
  void apply(const std::vector<Assignment>& assignments) { apply(std::nullopt, assignments); }

  /// Warnings of the last apply(): a sentence for every assignment of an older version. The caller
  /// prints them.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// One line per key: name, default, unit, range, meaning.
  std::string describe() const;
  /// The current values as a YAML file that `apply` reads back exactly.
  std::string to_yaml() const;
  /// Like to_yaml(), with meaning, unit, range and default of every key as comments, for editing.
  std::string to_documented_yaml() const;
  /// A JSON Schema (draft 2020-12) of the settings file, for editors: types, ranges, names,
  /// defaults and meanings.
  std::string json_schema(const std::string& title) const;
  /// The settings that differ from their defaults, as YAML.
  std::string changes_to_yaml() const;
  /// All keys, in the order of their declaration.
  std::vector<std::string> keys() const;
  /// All flags of the command line: the keys, then the aliases.
  std::vector<std::string> flags() const;
  /// Known values of a flag, for completion: names of a choice, true and false. Empty for other
  /// flags.
  std::vector<std::string> values_of(std::string_view flag) const;

 private:
  // A field of any enumeration type, read and written as an index of the names.
  struct ChoiceField {
    std::function<std::optional<std::size_t>()> index;
    std::function<void(std::size_t)> assign;
  };
  using Field = std::variant<double*, std::optional<double>*, int*, bool*, std::string*,
                             std::span<double>, ChoiceField>;
  using Value = std::variant<double, std::optional<double>, int, bool, std::string,
                             std::vector<double>, std::size_t>;
  struct Setting {
    std::string key;
    Field field;
    std::string unit;
    std::string doc;
    Range range;
    std::vector<std::string> names;  // names of a choice
    std::string default_text;
  };
  struct Rule {
    std::vector<std::string> keys;
    std::function<std::string()> complaint;
  };
  struct Renamed {
    std::string old_key, key, version;
  };
  struct Removed {
    std::string key, value, version;
  };
  struct PresetList {
    std::string key;
    std::vector<std::string> names;
    std::vector<Assignment> values;
  };
  struct Change {
    const Setting* setting;
    Value value;
    std::string location;
  };

  void declare(Setting setting);
  const Setting* find(std::string_view key_or_alias, Assignment::Origin origin) const;
  const Renamed* find_renamed(std::string_view old_key) const;
  void stage(const std::vector<Assignment>& assignments, std::vector<Change>& changes);
  std::string to_yaml(const std::function<bool(const Setting&)>& is_wanted,
                      bool is_documented = false) const;
  const Removed* find_removed(const Assignment& assignment) const;
  void add_presets(std::vector<Change>& changes) const;
  void check_rules(const std::vector<Change>& changes) const;
  [[noreturn]] void reject_unknown(const Assignment& assignment) const;

  static Value current_value(const Setting& setting);
  static Value parse(const Setting& setting, const Assignment& assignment);
  static void assign(const Setting& setting, const Value& value);
  static std::string yaml_text(const Setting& setting, const Value& value);
  static std::string allowed_text(const Setting& setting);
  static std::string documentation(const Setting& setting, std::size_t indentation);

  std::vector<Setting> settings_;
  std::vector<std::pair<std::string, std::string>> aliases_;  // flag and key
  std::vector<Renamed> renamed_;
  std::vector<Removed> removed_;
  std::vector<PresetList> presets_;  // in the order of their declaration
  Translation translation_;
  std::vector<Rule> rules_;
  std::vector<std::string> warnings_;
};

template <class Enum>
void Settings::choice(std::string key, Enum& field,
                      std::vector<std::pair<std::string, Enum>> named_values, std::string doc) {
  std::vector<std::string> names;
  std::vector<Enum> values;
  for (auto& [name, value] : named_values) {
    names.push_back(std::move(name));
    values.push_back(value);
  }
  ChoiceField choice_field;
  choice_field.index = [&field, values]() -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] == field) return i;
    }
    return std::nullopt;
  };
  choice_field.assign = [&field, values](std::size_t index) { field = values[index]; };
  declare({std::move(key), std::move(choice_field), "", std::move(doc), {}, std::move(names), ""});
}

}  // namespace saltus
