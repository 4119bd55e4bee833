// A section of one of our own YAML files, asked for its keys by what they must be.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/yaml/yaml_file.hpp"

namespace saltus {

/// A view; the entry must outlive it. Everything throws InputError, one sentence with the file and
/// the way to the key: "robot.yaml: postures.stand.com must be a list of 3 numbers".
class YamlSection {
 public:
  /// `source` stands for the file in messages.
  YamlSection(const YamlEntry& entry, std::string source)
      : YamlSection(entry, std::move(source), "") {}

  std::vector<std::string> keys() const;  ///< in the order of the file
  /// Whether the key is there.
  bool has(const std::string& key) const { return find(key) != nullptr; }
  /// Refuses any other key and suggests the nearest of these.
  void allow_only(const std::vector<std::string>& known) const;

  // The value of a key, which must be there and of that type.
  /// That of the key; InputError if it is none.
  YamlSection section(const std::string& key) const;
  /// InputError if it is none.
  std::string text(const std::string& key) const;
  /// InputError if they are none.
  std::vector<std::string> texts(const std::string& key) const;
  double number(const std::string& key) const;  ///< finite
  /// InputError unless there are n.
  template <int n>
  Vec<double, n> numbers(const std::string& key) const {
    return numbers(key, n);
  }
  Bounds range(const std::string& key) const;  ///< [lower, upper] with lower < upper

  /// Says what is wrong with a key, or with the section for an empty one.
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

 private:
  YamlSection(const YamlEntry& entry, std::string source, std::string path);
  const YamlEntry* find(const std::string& key) const;
  const YamlEntry& require(const std::string& key) const;
  std::string way_to(const std::string& key) const;
  VectorXd numbers(const std::string& key, int count) const;
  double number(const std::string& text, const std::string& key) const;

  const YamlEntry* entry_;
  std::string source_, path_;
};

}  // namespace saltus
