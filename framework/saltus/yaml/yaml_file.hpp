// Parses the YAML files of this project: keys with values, lists of values, and sections.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace saltus {

/// A key with its value as written.
struct YamlEntry {
  enum class Form { none, scalar, list, section };  ///< `none`: a key without a value

  std::string key;                 ///< as in the file
  int line = 0;                    ///< line of the key, from 1
  Form form = Form::none;          ///< form of the value
  std::vector<std::string> items;  ///< one for a scalar, any number for a list
  std::vector<YamlEntry> entries;  ///< of a section, in the order of the file
};

/// Returns the file as a section without a name. Throws InputError, one sentence with file and
/// line, if the file is missing, a folder, unreadable or empty; if it is not YAML, contains several
/// documents, or consists of anything but keys with plain values and lists; or if a key is
/// repeated, also with dots instead of a section. A file of comments has no entries.
YamlEntry read_yaml(const std::filesystem::path& file);
/// The same from text; `source` is the file name in messages.
YamlEntry parse_yaml(const std::string& text, const std::string& source);

}  // namespace saltus
