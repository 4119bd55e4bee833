// What stands in one of our own YAML files: keys with values, lists of values, and sections of
// these.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace saltus {

/// A key with what was written after it, not yet understood.
struct YamlEntry {
  enum class Form { none, scalar, list, section };  ///< `none`: a key without a value

  std::string key;                 ///< as in the file
  int line = 0;                    ///< of the key, from 1
  Form form = Form::none;          ///< what stands there
  std::vector<std::string> items;  ///< one for a scalar, any number for a list
  std::vector<YamlEntry> entries;  ///< of a section, in the order of the file
};

/// The file as a section without a name. Throws InputError, one sentence with file and line: the
/// file is missing, a folder, unreadable or empty; it is not YAML, holds several documents, or is
/// not made of keys with values and lists of plain values; a key stands twice, also when it is
/// written once in a section and once with dots. A file of comments alone has no entries.
YamlEntry read_yaml(const std::filesystem::path& file);
/// The same from text; `source` stands for the file in messages.
YamlEntry parse_yaml(const std::string& text, const std::string& source);

}  // namespace saltus
