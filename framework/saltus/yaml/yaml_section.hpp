// Typed access to a section of a YAML file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

// Parses the YAML files of this project: keys with values, lists of values, and sections.

/// A key with its value as written.
struct YamlEntry {
  enum class Form { none, scalar, list, section };  ///< `none`: a key without a value

  std::string key;                 ///< name as in the file
  int line = 0;                    ///< line of the key, from 1
  Form form = Form::none;          ///< form of the value
  std::vector<std::string> items;  ///< one for a scalar, any number for a list
  std::vector<YamlEntry> entries;  ///< entries of a section, in file order
};

/// Returns the file as a section without a name. Throws InputError, one sentence with file and
/// line, if the file is missing, a folder, unreadable or empty; if it is not YAML, contains several
/// documents, or consists of anything but keys with plain values and lists; or if a key is
/// repeated, also with dots instead of a section. A file of comments has no entries.
YamlEntry read_yaml(const std::filesystem::path& file);
/// The same from text; `source` is the file name in messages.
YamlEntry parse_yaml(const std::string& text, const std::string& source);

/// Typed access to the entries of a section. It is a view of an entry, which must outlive it. All
/// errors throw InputError, one sentence with the file and the path of the key: "robot.yaml:
/// postures.stand.com must be a list of 3 numbers".
class YamlSection {
 public:
  /// `source` is the file name in messages.
  YamlSection(const YamlEntry& entry, std::string source)
      : YamlSection(entry, std::move(source), "") {}

  std::vector<std::string> keys() const;  ///< names in the order of the file
  /// True if the key exists.
  bool has(const std::string& key) const { return find(key) != nullptr; }
  /// Rejects all other keys and suggests the nearest known one.
  void allow_only(const std::vector<std::string>& known) const;

  // Values of a key. They throw InputError if the key is missing or has a different type.
  /// Section of the key.
  YamlSection section(const std::string& key) const;
  /// Text of the key.
  std::string text(const std::string& key) const;
  /// Texts of the list of the key.
  std::vector<std::string> texts(const std::string& key) const;
  double number(const std::string& key) const;  ///< finite
  /// List of exactly n numbers.
  template <int n>
  Vec<double, n> numbers(const std::string& key) const {
    return numbers(key, n);
  }
  Bounds range(const std::string& key) const;  ///< [lower, upper] with lower < upper

  /// Throws an error about a key, or about the section if `key` is empty.
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

 private:
  YamlSection(const YamlEntry& entry, std::string source, std::string path);
  const YamlEntry* find(const std::string& key) const;
  const YamlEntry& require(const std::string& key) const;
  std::string path_to_key(const std::string& key) const;
  VectorXd numbers(const std::string& key, int count) const;
  double number(const std::string& text, const std::string& key) const;

  const YamlEntry* entry_;
  std::string source_, path_;
};

}  // namespace saltus
