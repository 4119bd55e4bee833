#include "saltus/yaml/yaml_section.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <sstream>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/file_content.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

// Files of this project are small. Larger numbers indicate an error, or a file that refers to
// itself.
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
    // Marks count from zero; nodes that are not in the text have the line -1.
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
    if (++count_ > max_keys) throw InputError(source_ + ": too many keys");
    const auto [first, is_new] = where_.emplace(path, where(key));
    if (!is_new)
      throw InputError(fmt::format("{}: key '{}' was already given at {}", where(key),
                                   shortened(path), first->second));
    if (value.IsMap()) {
      entry.form = YamlEntry::Form::section;
      entry.entries = section(value, path + ".", depth + 1);
    } else if (value.IsSequence()) {
      entry.form = YamlEntry::Form::list;
      for (const YAML::Node& item : value) {
        if (!item.IsScalar())
          throw InputError(
              fmt::format("{}: '{}' must be a list of plain values", where(key), shortened(path)));
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
  std::map<std::string, std::string> where_;  // location of each dotted key
};

// Rejects texts before a tree is built. yaml-cpp reads ", 2]" as endless documents, its parser
// recurses, and aliases let a short text expand to a very long one.
class Scan : public YAML::EventHandler {
 public:
  explicit Scan(const std::string& source) : source_(source) {}

  /// Throws InputError for invalid texts. An empty text is valid.
  void run(const std::string& text) {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(*this)) return;
    const YAML::Mark first = start_;
    if (!parser.HandleNextDocument(*this)) return;
    if (start_.pos == first.pos) refuse(first, "not valid YAML: a value cannot begin like this");
    refuse(start_, "a second YAML document begins here; only one is allowed");
  }

  void OnDocumentStart(const YAML::Mark& mark) override { start_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    refuse(mark, "aliases (*name) are not supported; write the value out");
  }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    deeper(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    deeper(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void deeper(const YAML::Mark& mark) {
    if (++depth_ > max_depth) refuse(mark, "sections are nested too deeply");
  }
  [[noreturn]] void refuse(const YAML::Mark& mark, const char* why) const {
    throw InputError(fmt::format("{}:{}: {}", source_, mark.line + 1, why));
  }

  const std::string& source_;
  YAML::Mark start_;
  std::size_t depth_ = 0;
};

}  // namespace

YamlEntry parse_yaml(const std::string& text, const std::string& source) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(source + ": the file is empty");
  try {
    Scan(source).run(text);
    const YAML::Node document = YAML::Load(text);
    YamlEntry root;
    root.form = YamlEntry::Form::section;
    if (document.IsNull()) return root;
    if (!document.IsMap())
      throw InputError(
          fmt::format("{}:{}: expected 'key: value'; the file must be a set of keys with values",
                      source, document.Mark().line + 1));
    root.entries = Reader(source).section(document, "", 1);
    return root;
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}: not valid YAML: {}", source, error.mark.line + 1, error.msg));
  }
}

YamlEntry read_yaml(const fs::path& file) { return parse_yaml(file_content(file), file.string()); }

}  // namespace saltus
