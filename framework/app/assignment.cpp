#include "saltus/app/assignment.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iterator>
#include <map>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

// A configuration is small: more than this is a mistake (or a file that refers to itself).
constexpr std::size_t max_depth = 16;
constexpr std::size_t max_assignments = 10000;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space = " \t\r\n";
  const auto first = text.find_first_not_of(space);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(space) - first + 1);
}

std::string read_whole_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) {
    throw InputError(fmt::format("configuration file '{}' does not exist", file.string()));
  }
  if (fs::is_directory(status)) {
    throw InputError(fmt::format("configuration file '{}' is a folder", file.string()));
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream.good() && !stream.eof()) {
    throw InputError(fmt::format("configuration file '{}' cannot be read", file.string()));
  }
  if (trimmed(text).empty()) {
    throw InputError(fmt::format("configuration file '{}' is empty", file.string()));
  }
  return text;
}

// Turns the tree of a YAML document into a list of dotted keys.
class Flattener {
 public:
  explicit Flattener(std::string file) : file_(std::move(file)) {}

  void add_map(const YAML::Node& map, const std::string& prefix, std::size_t depth) {
    if (depth > max_depth) throw InputError(place(map) + ": sections are nested too deeply");
    for (const auto& entry : map) {
      const YAML::Node& key = entry.first;
      const YAML::Node& value = entry.second;
      if (!key.IsScalar() || key.Scalar().empty()) {
        throw InputError(place(key) + ": a key must be a name");
      }
      const std::string path = prefix.empty() ? key.Scalar() : prefix + "." + key.Scalar();
      if (value.IsMap() && value.size() > 0) {
        add_map(value, path, depth + 1);
      } else {
        add_value(path, key, value);
      }
    }
  }

  std::vector<Assignment> take() { return std::move(list_); }

 private:
  std::string place(const YAML::Node& node) const {
    // Marks count from zero; a node that was never written has the line -1.
    return node.Mark().line < 0 ? file_ : fmt::format("{}:{}", file_, node.Mark().line + 1);
  }

  void add_value(const std::string& path, const YAML::Node& key, const YAML::Node& value) {
    if (list_.size() >= max_assignments) throw InputError(file_ + ": far too many settings");
    const auto [first, is_new] = place_of_.emplace(path, place(key));
    if (!is_new) {
      throw InputError(
          fmt::format("{}: key '{}' was already given at {}", place(key), path, first->second));
    }
    Assignment assignment;
    assignment.key = path;
    assignment.origin = Assignment::Origin::file;
    assignment.place = place(key);
    if (value.IsScalar()) {
      assignment.form = Assignment::Form::scalar;
      assignment.items = {value.Scalar()};
    } else if (value.IsSequence()) {
      assignment.form = Assignment::Form::list;
      for (const YAML::Node& item : value) {
        if (!item.IsScalar()) {
          throw InputError(
              fmt::format("{}: '{}' must be a list of plain values", place(key), path));
        }
        assignment.items.push_back(item.Scalar());
      }
    }
    list_.push_back(std::move(assignment));
  }

  std::string file_;
  std::map<std::string, std::string> place_of_;
  std::vector<Assignment> list_;
};

Assignment from_text(std::string_view key, std::string_view value) {
  Assignment assignment;
  assignment.key = std::string(trimmed(key));
  std::string_view text = trimmed(value);
  if (text.size() >= 2 && text.front() == '[' && text.back() == ']') {
    assignment.form = Assignment::Form::list;
    text = trimmed(text.substr(1, text.size() - 2));
    while (!text.empty()) {
      const auto comma = text.find(',');
      assignment.items.emplace_back(trimmed(text.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      text.remove_prefix(comma + 1);
      if (text.empty()) assignment.items.emplace_back();  // a comma that nothing follows
    }
  } else {
    assignment.form = Assignment::Form::scalar;
    assignment.items = {std::string(text)};
  }
  return assignment;
}

}  // namespace

std::vector<Assignment> read_yaml_file(const fs::path& file) {
  const std::string text = read_whole_file(file);
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1) {
      throw InputError(fmt::format("{}: holds {} YAML documents; one is expected", file.string(),
                                   documents.size()));
    }
    if (documents.empty() || documents[0].IsNull() ||
        (documents[0].IsMap() && documents[0].size() == 0)) {
      throw InputError(fmt::format("configuration file '{}' holds no settings", file.string()));
    }
    if (!documents[0].IsMap()) {
      throw InputError(
          fmt::format("{}:{}: expected 'key: value'", file.string(), documents[0].Mark().line + 1));
    }
    Flattener flattener(file.string());
    flattener.add_map(documents[0], "", 1);
    return flattener.take();
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}: not valid YAML: {}", file.string(), error.mark.line + 1, error.msg));
  }
}

Assignment parse_set_argument(std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos || trimmed(text.substr(0, equals)).empty()) {
    throw InputError(fmt::format("--set {}: expected KEY=VALUE", text));
  }
  Assignment assignment = from_text(text.substr(0, equals), text.substr(equals + 1));
  assignment.origin = Assignment::Origin::set;
  assignment.place = fmt::format("--set {}", text);
  return assignment;
}

Assignment flag_assignment(std::string_view flag, std::string_view value) {
  Assignment assignment = from_text(flag, value);
  assignment.origin = Assignment::Origin::flag;
  assignment.place = fmt::format("--{}", flag);
  return assignment;
}

Assignment bare_flag_assignment(std::string_view flag) {
  Assignment assignment;
  assignment.key = std::string(flag);
  assignment.origin = Assignment::Origin::flag;
  assignment.place = fmt::format("--{}", flag);
  return assignment;
}

}  // namespace saltus
