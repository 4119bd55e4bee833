// Which keys a program understands, and how text from outside becomes values of plain structs.
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

#include "saltus/app/assignment.hpp"
#include "saltus/app/range.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// A registry of keys, each bound to a field of a struct that outlives the registry. The value the
/// field has when it is declared is its default.
///
///     PushConfig config;
///     Settings settings;
///     settings.number("push.impulse", config.push.impulse, "N s", "size of the push",
///     at_least(0)); settings.flag("stepping", config.stepping, "may the robot step?");
///     settings.apply("push.yaml", {parse_set_argument("push.impulse=8")});
///
/// Declaring is programming: a key declared twice, or a default outside its range, throws
/// DefinitionError. Applying reads what a user wrote: whatever is wrong throws InputError, one
/// sentence with location, key, value and remedy, and leaves every field as it was.
class Settings {
 public:
  /// A finite number. `unit` is for the reader ("" if there is none).
  void number(std::string key, double& field, std::string unit, std::string doc, Range range = {});
  /// A finite number, or "none".
  void number(std::string key, std::optional<double>& field, std::string unit, std::string doc,
              Range range = {});
  /// A whole number.
  void integer(std::string key, int& field, std::string unit, std::string doc, Range range = {});
  /// true or false.
  void flag(std::string key, bool& field, std::string doc);
  /// Any text, a file name for example.
  void text(std::string key, std::string& field, std::string doc);
  /// A list of exactly field.size() numbers, each within `range`.
  void vector(std::string key, VectorOut field, std::string unit, std::string doc,
              Range range = {});
  /// One of some names.
  void choice(std::string key, std::string& field, std::vector<std::string> names, std::string doc);
  /// One of some names, each standing for a value of an enumeration.
  template <class Enum>
  void choice(std::string key, Enum& field, std::vector<std::pair<std::string, Enum>> named_values,
              std::string doc);

  /// A name for values of other settings, each "KEY=VALUE" as --set takes it.
  struct Preset {
    std::string name;                 ///< as the user gives it
    std::vector<std::string> values;  ///< each "KEY=VALUE"
  };
  /// One of some presets. Its values act when apply() is given `key`; whatever else apply() is
  /// given wins over them, in a file too. Every key must have been declared before, and the field's
  /// default names the preset to which all other defaults belong.
  void preset(std::string key, std::string& field, const std::vector<Preset>& presets,
              std::string doc);

  /// When apply() is given one of `values` for the choice or flag `key`, it takes `assignment`
  /// ("KEY=VALUE" as --set takes it) for given too, unless something else is given for that key.
  /// What is implied may imply more, by what is declared after it. Both keys must have been
  /// declared before.
  void implies(const std::string& key, const std::vector<std::string>& values,
               const std::string& assignment);

  /// Lets a flag of the command line stand for a key: alias("urdf", "robot.urdf").
  void alias(std::string flag, const std::string& key);

  /// A key that had another name: the old one is still understood, in files and on the command
  /// line, with a warning. `version` in which it will be gone.
  void renamed(std::string old_key, const std::string& key, std::string version);

  /// A condition on several settings, checked after all are known. `complaint` returns what is
  /// wrong ("contact.fz_min (50) exceeds contact.fz_max (20)"), or an empty string; the message
  /// is preceded by the location that set one of `keys` last.
  void rule(std::vector<std::string> keys, std::function<std::string()> complaint);

  /// Reads the file, if one is given, then the assignments, which win. All or nothing.
  void apply(const std::optional<std::filesystem::path>& file,
             const std::vector<Assignment>& assignments);
  /// The same for assignments alone. A key that occurs twice among them is an error.
  void apply(const std::vector<Assignment>& assignments) { apply(std::nullopt, assignments); }

  /// Of the last apply(): one sentence for every key that was given by an old name. Whoever prints
  /// shows them.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// One line per key: name, default, unit, what is allowed, what it means.
  std::string describe() const;
  /// The values the fields have now, as a YAML file that `apply` reads back exactly.
  std::string to_yaml() const;
  /// The same with meaning, unit, range and default of every key as comments: to be edited and
  /// given back.
  std::string to_documented_yaml() const;
  /// A JSON Schema (draft 2020-12) of the files that apply() reads, for editors: types, ranges,
  /// names, defaults, meanings.
  std::string json_schema(const std::string& title) const;
  /// Of these the ones whose values are not their defaults.
  std::string changes_to_yaml() const;
  /// All keys, in the order of their declaration.
  std::vector<std::string> keys() const;
  /// What --NAME can be on a command line: the keys, then the aliases.
  std::vector<std::string> flags() const;
  /// The values of a flag that can be told beforehand: names of a choice, true and false. Empty for
  /// others, and for what is no flag.
  std::vector<std::string> values_of(std::string_view flag) const;

 private:
  // A field of unknown enumeration type: read and written as the index of a name.
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
    std::vector<std::string> names;  // of a choice
    std::string default_text;
  };
  struct Rule {
    std::vector<std::string> keys;
    std::function<std::string()> complaint;
  };
  struct Renamed {
    std::string old_key, key, version;
  };
  struct PresetChoice {
    std::string key;
    std::vector<Preset> presets;
  };
  struct Implication {
    std::string key;
    std::vector<std::string> values;
    std::string assignment;
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
  void add_implied(std::vector<Change>& changes) const;
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
  std::vector<std::pair<std::string, std::string>> aliases_;  // flag, key
  std::vector<Renamed> renamed_;
  std::vector<PresetChoice> presets_;
  std::vector<Implication> implications_;
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
