#include "saltus/yaml/yaml_section.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {

using Form = YamlEntry::Form;

YamlSection::YamlSection(const YamlEntry& entry, std::string source, std::string path)
    : entry_(&entry), source_(std::move(source)), path_(std::move(path)) {
  if (entry.form != Form::section) fail("", "must be a set of keys with values");
}

std::vector<std::string> YamlSection::keys() const {
  std::vector<std::string> names;
  for (const YamlEntry& e : entry_->entries) names.push_back(e.key);
  return names;
}

void YamlSection::allow_only(const std::vector<std::string>& known) const {
  for (const YamlEntry& e : entry_->entries) {
    if (std::find(known.begin(), known.end(), e.key) != known.end()) continue;
    const std::string nearest = nearest_name(e.key, known);
    fail(e.key, nearest.empty() ? "is not a known key; known keys are " + join_names(known)
                                : fmt::format("is not a known key; did you mean \"{}\"?", nearest));
  }
}

YamlSection YamlSection::section(const std::string& key) const {
  return {require(key), source_, path_to_key(key)};
}

std::string YamlSection::text(const std::string& key) const {
  const YamlEntry& value = require(key);
  if (value.form != Form::scalar || value.items[0].empty()) fail(key, "must be a text");
  return value.items[0];
}

std::vector<std::string> YamlSection::texts(const std::string& key) const {
  const YamlEntry& value = require(key);
  const auto& items = value.items;
  if (value.form != Form::list ||
      std::any_of(items.begin(), items.end(), [](const std::string& t) { return t.empty(); }))
    fail(key, "must be a list of texts");
  return items;
}

double YamlSection::number(const std::string& key) const {
  const YamlEntry& value = require(key);
  if (value.form != Form::scalar) fail(key, "must be a number");
  return number(value.items[0], key);
}

Bounds YamlSection::range(const std::string& key) const {
  const Vec<double, 2> ends = numbers<2>(key);
  if (!(ends[0] < ends[1]))
    fail(key, fmt::format("is empty, from {} to {}; give the smaller first", ends[0], ends[1]));
  return between(ends[0], ends[1]);
}

void YamlSection::fail(const std::string& key, const std::string& what) const {
  const std::string way = key.empty() ? path_ : path_to_key(key);
  throw InputError(
      fmt::format("{}: {} {}", source_, way.empty() ? "the file" : shortened(way), what));
}

const YamlEntry* YamlSection::find(const std::string& key) const {
  for (const YamlEntry& e : entry_->entries)
    if (e.key == key) return &e;
  return nullptr;
}

const YamlEntry& YamlSection::require(const std::string& key) const {
  const YamlEntry* found = find(key);
  if (!found) fail(key, "is missing; add it");
  return *found;
}

std::string YamlSection::path_to_key(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

VectorXd YamlSection::numbers(const std::string& key, int count) const {
  const YamlEntry& value = require(key);
  if (value.form != Form::list || value.items.size() != static_cast<std::size_t>(count))
    fail(key, fmt::format("must be a list of {} numbers", count));
  VectorXd result(count);
  for (int i = 0; i < count; ++i) result[i] = number(value.items[i], key);
  return result;
}

double YamlSection::number(const std::string& text, const std::string& key) const {
  double value = 0.0;
  if (!YAML::convert<double>::decode(YAML::Node(text), value))
    fail(key, fmt::format("must be a number, not \"{}\"", shortened(text)));
  if (!std::isfinite(value)) fail(key, fmt::format("must be finite, not {}", value));
  return value;
}

}  // namespace saltus
