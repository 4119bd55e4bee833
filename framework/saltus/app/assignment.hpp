// One "key = value" from a file or the command line, with its source.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// A value as written. `Settings` converts it to the type of its key.
struct Assignment {
  /// Source of the text: a file, --set, or a flag.
  enum class Origin { file, set, flag };
  enum class Form { scalar, list, none };  ///< `none`: a key without a value

  std::string key;                 ///< dotted, as written: "push.impulse"
  Form form = Form::none;          ///< how the value was written
  std::vector<std::string> items;  ///< one entry for a scalar, any number for a list
  Origin origin = Origin::set;     ///< source
  std::string location;  ///< source for messages: "push.yaml:3", "--set push.impulse=7", "--urdf"
};

/// Reads the settings of a YAML file, in the order of the file. Nested maps become dotted keys.
/// Throws InputError as `read_yaml` does, and if the file has no setting.
std::vector<Assignment> read_assignments(const std::filesystem::path& file);

/// Parses the "KEY=VALUE" of --set. Lists are written [a, b, c] or a,b,c. Throws InputError if the
/// '=' or the key is missing.
Assignment parse_set_argument(std::string_view text);

/// The assignment of a flag: `--urdf robot.urdf` means `--set urdf=robot.urdf`.
Assignment flag_assignment(std::string_view flag, std::string_view value);

/// A flag without a value (`--stepping`), which only boolean settings accept.
Assignment bare_flag_assignment(std::string_view flag);

}  // namespace saltus
