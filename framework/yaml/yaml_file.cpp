#include "saltus/yaml/yaml_file.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

// Our files are small: more than this is a mistake (or a file that refers to itself).
constexpr std::size_t max_depth = 16;
constexpr std::size_t max_keys = 10000;

class Reader {
 public:
  explicit Reader(std::string source) : source_(std::move(source)) {}

  std::vector<YamlEntry> section(const YAML::Node& map, const std::string& prefix,
                                 std::size_t depth) {
    if (depth > max_depth) throw InputError(where(map) + ": sections are nested too deeply");
    std::vector<YamlEntry> entries;
    for (const auto& entry : map) entries.push_back(read(entry.first, entry.second, prefix, depth));
    return entries;
  }

 private:
  std::string where(const YAML::Node& node) const {
    // Marks count from zero; a node that was never written has the line -1.
    return node.Mark().line < 0 ? source_ : fmt::format("{}:{}", source_, node.Mark().line + 1);
  }

  YamlEntry read(const YAML::Node& key, const YAML::Node& value, const std::string& prefix,
                 std::size_t depth) {
    if (!key.IsScalar() || key.Scalar().empty())
      throw InputError(where(key) + ": a key must be a name");
    YamlEntry entry;
    entry.key = key.Scalar();
    entry.line = key.Mark().line + 1;
    const std::string path = prefix + entry.key;
    if (++count_ > max_keys) throw InputError(source_ + ": far too many keys");
    const auto [first, is_new] = where_.emplace(path, where(key));
    if (!is_new)
      throw InputError(
          fmt::format("{}: key '{}' was already given at {}", where(key), path, first->second));
    if (value.IsMap()) {
      entry.form = YamlEntry::Form::section;
      entry.entries = section(value, path + ".", depth + 1);
    } else if (value.IsSequence()) {
      entry.form = YamlEntry::Form::list;
      for (const YAML::Node& item : value) {
        if (!item.IsScalar())
          throw InputError(
              fmt::format("{}: '{}' must be a list of plain values", where(key), path));
        entry.items.push_back(item.Scalar());
      }
    } else if (value.IsScalar()) {
      entry.form = YamlEntry::Form::scalar;
      entry.items = {value.Scalar()};
    }
    return entry;
  }

  std::string source_;
  std::size_t count_ = 0;
  std::map<std::string, std::string> where_;  // of each key with dots
};

std::string read_whole_file(const fs::path& file) {
  const auto refuse = [&](const char* why) {
    throw InputError(fmt::format("{}: {}", file.string(), why));
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) refuse("there is no such file");
  if (fs::is_directory(status)) refuse("this is a folder, not a file");
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream.good() && !stream.eof()) refuse("the file cannot be read; check its permissions");
  return text;
}

}  // namespace

YamlEntry parse_yaml(const std::string& text, const std::string& source) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(source + ": the file is empty");
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1)
      throw InputError(
          fmt::format("{}: holds {} YAML documents; one is expected", source, documents.size()));
    YamlEntry root;
    root.form = YamlEntry::Form::section;
    if (documents.empty() || documents[0].IsNull()) return root;
    if (!documents[0].IsMap())
      throw InputError(
          fmt::format("{}:{}: expected 'key: value'; the file must be a set of keys with values",
                      source, documents[0].Mark().line + 1));
    root.entries = Reader(source).section(documents[0], "", 1);
    return root;
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}: not valid YAML: {}", source, error.mark.line + 1, error.msg));
  }
}

YamlEntry read_yaml(const fs::path& file) {
  return parse_yaml(read_whole_file(file), file.string());
}

}  // namespace saltus
