#include "saltus/app/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "saltus/app/overloaded.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
// ---- declaring ----------------------------------------------------------------------------------

void Settings::number(std::string key, double& field, std::string unit, std::string doc,
                      Range range) {
  declare({std::move(key), &field, std::move(unit), std::move(doc), range, {}, ""});
}

void Settings::number(std::string key, std::optional<double>& field, std::string unit,
                      std::string doc, Range range) {
  declare({std::move(key), &field, std::move(unit), std::move(doc), range, {}, ""});
}

void Settings::integer(std::string key, int& field, std::string unit, std::string doc,
                       Range range) {
  declare({std::move(key), &field, std::move(unit), std::move(doc), range, {}, ""});
}

void Settings::flag(std::string key, bool& field, std::string doc) {
  declare({std::move(key), &field, "", std::move(doc), {}, {}, ""});
}

void Settings::text(std::string key, std::string& field, std::string doc) {
  declare({std::move(key), &field, "", std::move(doc), {}, {}, ""});
}

void Settings::vector(std::string key, VectorOut field, std::string unit, std::string doc,
                      Range range) {
  const std::span<double> numbers(field.data(), static_cast<std::size_t>(field.size()));
  declare({std::move(key), numbers, std::move(unit), std::move(doc), range, {}, ""});
}

void Settings::choice(std::string key, std::vector<std::string> names,
                      std::function<std::optional<std::size_t>()> index,
                      std::function<void(std::size_t)> assign, std::string doc) {
  declare({std::move(key),
           ChoiceField{std::move(index), std::move(assign)},
           "",
           std::move(doc),
           {},
           std::move(names),
           ""});
}

void Settings::choice(std::string key, std::string& field, std::vector<std::string> names,
                      std::string doc) {
  ChoiceField choice_field;
  choice_field.index = [&field, names]() -> std::optional<std::size_t> {
    const auto it = std::find(names.begin(), names.end(), field);
    if (it == names.end()) return std::nullopt;
    return static_cast<std::size_t>(it - names.begin());
  };
  choice_field.assign = [&field, names](std::size_t index) { field = names[index]; };
  declare({std::move(key), std::move(choice_field), "", std::move(doc), {}, std::move(names), ""});
}

void Settings::preset(const std::string& key, const std::vector<std::string>& names,
                      const std::vector<std::string>& values) {
  const auto cause = std::ranges::find(settings_, key, &Setting::key);
  for (const std::string& name : names)
    if (cause == settings_.end() || std::ranges::find(cause->names, name) == cause->names.end())
      throw DefinitionError(
          fmt::format("preset '{}': there is no choice '{}' with this name", name, key));
  PresetList preset{key, names, {}};
  for (const std::string& value : values) {
    const Assignment& assignment = preset.values.emplace_back(parse_set_argument(value));
    const Setting* setting = find(assignment.key, Assignment::Origin::set);
    if (setting == nullptr)
      throw DefinitionError(fmt::format("preset '{}' of '{}': there is no setting '{}'",
                                        fmt::join(names, ", "), key, assignment.key));
    parse(*setting, assignment);  // throws if this is not a value of that setting
  }
  cause->doc += fmt::format("; {}: {}", fmt::join(names, ", "), fmt::join(values, ", "));
  presets_.push_back(std::move(preset));
}

void Settings::preset(std::string key, std::string& field, const std::vector<Preset>& presets,
                      std::string doc) {
  std::vector<std::string> names;
  for (const Preset& one : presets) names.push_back(one.name);
  choice(key, field, std::move(names), std::move(doc));
  for (const Preset& one : presets)
    if (!one.values.empty()) preset(key, {one.name}, one.values);
}

void Settings::declare(Setting setting) {
  const auto complain = [&](std::string_view what) {
    throw DefinitionError(fmt::format("setting '{}': {}", setting.key, what));
  };
  if (find_renamed(setting.key) != nullptr) complain("it is an old name of another setting");
  for (const Setting& other : settings_) {
    if (other.key == setting.key) complain("declared twice");
    if (other.key.starts_with(setting.key + ".") || setting.key.starts_with(other.key + ".")) {
      complain(fmt::format("a key cannot be both a value and a section (see '{}')", other.key));
    }
  }
  const auto in_range = [&](double value) { return setting.range.contains(value); };
  const bool default_is_allowed = std::visit(
      Overloaded{[&](const double* field) { return std::isfinite(*field) && in_range(*field); },
                 [&](const std::optional<double>* field) { return !*field || in_range(**field); },
                 [&](const int* field) { return in_range(*field); },
                 [&](const std::span<double>& field) {
                   return std::all_of(field.begin(), field.end(), in_range);
                 },
                 [&](const ChoiceField& field) { return field.index().has_value(); },
                 [](const auto*) { return true; }},
      setting.field);
  if (!default_is_allowed) complain("its default is not among the allowed values");
  setting.default_text = yaml_text(setting, current_value(setting));
  settings_.push_back(std::move(setting));
}

void Settings::alias(std::string flag, const std::string& key) {
  if (find(key, Assignment::Origin::set) == nullptr) {
    throw DefinitionError(fmt::format("alias '{}': there is no setting '{}'", flag, key));
  }
  if (find(flag, Assignment::Origin::flag) != nullptr) {
    throw DefinitionError(fmt::format("alias '{}': the name is taken", flag));
  }
  aliases_.emplace_back(std::move(flag), key);
}

void Settings::renamed(std::string old_key, const std::string& key, std::string version) {
  if (find(key, Assignment::Origin::set) == nullptr)
    throw DefinitionError(fmt::format("old key '{}': there is no setting '{}'", old_key, key));
  if (find(old_key, Assignment::Origin::flag) != nullptr)
    throw DefinitionError(fmt::format("old key '{}': the name is taken", old_key));
  renamed_.push_back({std::move(old_key), key, std::move(version)});
}

void Settings::removed(std::string old_key, std::string value, std::string version) {
  if (find(old_key, Assignment::Origin::flag) != nullptr || find_renamed(old_key) != nullptr)
    throw DefinitionError(fmt::format("removed key '{}': the name is taken", old_key));
  removed_.push_back({std::move(old_key), std::move(value), std::move(version)});
}

void Settings::rule(std::vector<std::string> keys, std::function<std::string()> complaint) {
  for (const std::string& key : keys) {
    if (find(key, Assignment::Origin::set) == nullptr) {
      throw DefinitionError(fmt::format("rule: there is no setting '{}'", key));
    }
  }
  rules_.push_back({std::move(keys), std::move(complaint)});
}

// ---- applying -----------------------------------------------------------------------------------

void Settings::apply(const std::optional<std::filesystem::path>& file,
                     const std::vector<Assignment>& assignments) {
  std::vector<Change> changes;
  warnings_.clear();
  std::vector<Assignment> from_file, given = assignments;
  if (file) from_file = read_assignments(*file);
  if (translation_) warnings_ = translation_(from_file, given);
  stage(from_file, changes);
  stage(given, changes);
  add_presets(changes);

  std::vector<std::pair<const Setting*, Value>> before;
  before.reserve(changes.size());
  for (const Change& change : changes) {
    before.emplace_back(change.setting, current_value(*change.setting));
  }
  for (const Change& change : changes) assign(*change.setting, change.value);
  try {
    check_rules(changes);
  } catch (...) {
    for (const auto& [setting, value] : before) assign(*setting, value);
    throw;
  }
}

// Parses everything; assigns nothing.
void Settings::stage(const std::vector<Assignment>& assignments, std::vector<Change>& changes) {
  std::vector<std::pair<const Setting*, std::string>> seen;
  std::vector<std::string> removed;
  std::string location, version;  // of the first removed key
  for (const Assignment& assignment : assignments) {
    if (const Removed* old = find_removed(assignment)) {
      removed.push_back(old->key);
      if (removed.size() == 1) {
        location = assignment.location;
        version = old->version;
      }
      continue;
    }
    const Setting* setting = find(assignment.key, assignment.origin);
    if (const Renamed* old = find_renamed(assignment.key)) {
      setting = find(old->key, Assignment::Origin::set);
      warnings_.push_back(fmt::format("{}: '{}' is now called '{}'; the old name is removed in {}",
                                      assignment.location, old->old_key, old->key, old->version));
    }
    if (setting == nullptr) reject_unknown(assignment);
    for (const auto& [other, where] : seen) {
      if (other == setting) {
        throw InputError(fmt::format("{}: '{}' was already given by {}", assignment.location,
                                     setting->key, where));
      }
    }
    seen.emplace_back(setting, assignment.location);
    changes.push_back({setting, parse(*setting, assignment), assignment.location});
  }
  if (!removed.empty())
    warnings_.push_back(fmt::format(
        "{}: these are no longer settings and have fixed values: {}; they are rejected from {} on",
        location, join_names(removed), version));
}

const Settings::Removed* Settings::find_removed(const Assignment& given) const {
  const auto it = std::ranges::find(removed_, given.key, &Removed::key);
  if (it == removed_.end()) return nullptr;
  const auto number = [](const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    return end != text.c_str() && *end == '\0' ? value : std::nan("");
  };
  const bool is_same =
      given.items.size() == 1 &&
      (given.items.front() == it->value || number(given.items.front()) == number(it->value));
  if (!is_same)
    throw InputError(
        fmt::format("{}: '{}' is no longer a setting, its value is always {}; remove it "
                    "(docs/migration.md)",
                    given.location, given.key, it->value));
  return &*it;
}

// Applies the presets that the given settings select. Given settings override presets, and no
// preset triggers another one.
void Settings::add_presets(std::vector<Change>& changes) const {
  std::vector<Change> added;
  for (const PresetList& preset : presets_) {
    const auto given = std::find_if(changes.rbegin(), changes.rend(), [&](const Change& change) {
      return change.setting->key == preset.key;
    });
    if (given == changes.rend()) continue;
    const std::string& name = given->setting->names[std::get<std::size_t>(given->value)];
    if (std::ranges::find(preset.names, name) == preset.names.end()) continue;
    for (const Assignment& assignment : preset.values) {
      const Setting* setting = find(assignment.key, Assignment::Origin::set);
      added.push_back({setting, parse(*setting, assignment), given->location});
    }
  }
  changes.insert(changes.begin(), added.begin(), added.end());
}

void Settings::check_rules(const std::vector<Change>& changes) const {
  for (const Rule& rule : rules_) {
    const std::string complaint = rule.complaint();
    if (complaint.empty()) continue;
    const auto concerned = [&](const Change& change) {
      return std::find(rule.keys.begin(), rule.keys.end(), change.setting->key) != rule.keys.end();
    };
    const auto last = std::find_if(changes.rbegin(), changes.rend(), concerned);
    if (last == changes.rend()) throw InputError(complaint);
    throw InputError(fmt::format("{}: {}", last->location, complaint));
  }
}

const Settings::Setting* Settings::find(std::string_view name, Assignment::Origin origin) const {
  std::string_view key = name;
  if (origin == Assignment::Origin::flag) {
    for (const auto& [flag, meaning] : aliases_) {
      if (flag == name) key = meaning;
    }
  }
  const auto it = std::find_if(settings_.begin(), settings_.end(),
                               [&](const Setting& setting) { return setting.key == key; });
  return it == settings_.end() ? nullptr : &*it;
}

const Settings::Renamed* Settings::find_renamed(std::string_view old_key) const {
  const auto it = std::ranges::find(renamed_, old_key, &Renamed::old_key);
  return it == renamed_.end() ? nullptr : &*it;
}

void Settings::reject_unknown(const Assignment& given) const {
  const bool is_flag = given.origin == Assignment::Origin::flag;
  std::vector<std::string> known = keys();
  std::vector<std::string> inside;  // keys of the named section, or ending in the name
  for (const std::string& key : known) {
    if (key.starts_with(given.key + ".")) inside.push_back(key);
  }
  if (!inside.empty() && !is_flag) {
    throw InputError(fmt::format("{}: '{}' is a section, not a value; it contains {}",
                                 given.location, given.key, join_names(inside)));
  }
  if (is_flag) {
    for (const auto& [flag, key] : aliases_) known.push_back(flag);
    known.insert(known.end(), {"config", "set", "out", "help"});
  }
  std::string meant;
  for (const std::string& key : known) {
    if (meant.empty() && key.ends_with("." + given.key)) meant = key;
  }
  if (meant.empty()) meant = nearest_name(given.key, known);

  const std::string dashes = is_flag ? "--" : "";
  std::string message =
      is_flag ? fmt::format("unknown flag '--{}'", shortened(given.key))
              : fmt::format("{}: unknown key '{}'", given.location, shortened(given.key));
  if (!meant.empty()) {
    message += fmt::format("; did you mean '{}{}'?", dashes, meant);
  } else {
    message += "; --help lists all of them";
  }
  throw InputError(message);
}

// ---- text ---------------------------------------------------------------------------------------

std::string Settings::describe() const {
  std::vector<std::string> heads;
  std::size_t width = 0;
  for (const Setting& setting : settings_) {
    const bool has_unit = !setting.unit.empty() && setting.default_text != "none";
    heads.push_back(fmt::format("{}={}{}{}", setting.key, setting.default_text, has_unit ? " " : "",
                                has_unit ? setting.unit : ""));
    width = std::max(width, heads.back().size());
  }
  width = std::min<std::size_t>(width, 40);  // a longer head indents only its own line
  std::string text;
  for (std::size_t i = 0; i < settings_.size(); ++i) {
    const std::string allowed = allowed_text(settings_[i]);
    text += fmt::format("  {:<{}}  {}{}", heads[i], width, settings_[i].doc,
                        allowed.empty() ? "" : fmt::format(" ({})", allowed));
    for (const auto& [flag, key] : aliases_) {
      if (key == settings_[i].key) text += fmt::format(" [--{}]", flag);
    }
    text += "\n";
  }
  return text;
}

std::string Settings::to_yaml() const {
  return to_yaml([](const Setting&) { return true; });
}

std::string Settings::changes_to_yaml() const {
  return to_yaml([](const Setting& setting) {
    return yaml_text(setting, current_value(setting)) != setting.default_text;
  });
}

std::string Settings::to_documented_yaml() const {
  return to_yaml([](const Setting&) { return true; }, /*is_documented=*/true);
}

std::string Settings::to_yaml(const std::function<bool(const Setting&)>& is_wanted,
                              bool is_documented) const {
  std::string text;
  std::set<std::string> written;
  // Sections in the order of their first key, each written once with all its keys.
  const std::function<void(const std::string&)> write_section = [&](const std::string& section) {
    const std::size_t depth =
        static_cast<std::size_t>(std::count(section.begin(), section.end(), '.'));
    for (const Setting& setting : settings_) {
      if (!setting.key.starts_with(section) || written.contains(setting.key)) continue;
      if (!is_wanted(setting)) continue;
      const std::string rest = setting.key.substr(section.size());
      const std::size_t dot = rest.find('.');
      if (dot == std::string::npos && is_documented) text += documentation(setting, 2 * depth);
      text.append(2 * depth, ' ');
      if (dot == std::string::npos) {
        written.insert(setting.key);
        const std::string unit =
            setting.unit.empty() || is_documented ? "" : fmt::format("  # {}", setting.unit);
        text += fmt::format("{}: {}{}\n", rest, yaml_text(setting, current_value(setting)), unit);
      } else {
        text += rest.substr(0, dot) + ":\n";
        write_section(section + rest.substr(0, dot + 1));
      }
    }
  };
  write_section("");
  return text;
}

std::vector<std::string> Settings::keys() const {
  std::vector<std::string> keys;
  for (const Setting& setting : settings_) keys.push_back(setting.key);
  return keys;
}

std::vector<std::string> Settings::flags() const {
  std::vector<std::string> flags = keys();
  for (const auto& [flag, key] : aliases_) flags.push_back(flag);
  return flags;
}

std::vector<std::string> Settings::values_of(std::string_view flag) const {
  const Setting* setting = find(flag, Assignment::Origin::flag);
  if (setting == nullptr) return {};
  if (std::holds_alternative<bool*>(setting->field)) return {"true", "false"};
  return setting->names;
}

}  // namespace saltus
