// One "key = value" from outside the program, and where it was written.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// A value as it was written, not yet understood: `Settings` knows what it must be.
struct Assignment {
  /// Where the words came from: a file, --set, a flag of its own.
  enum class Origin { file, set, flag };
  enum class Form { scalar, list, none };  ///< `none`: a key without a value

  std::string key;                 ///< dotted, as written: "push.impulse"
  Form form = Form::none;          ///< how the value was written
  std::vector<std::string> items;  ///< one entry for a scalar, any number for a list
  Origin origin = Origin::set;     ///< where it came from
  std::string location;  ///< for messages: "push.yaml:3", "--set push.impulse=7", "--urdf"
};

/// The settings of a YAML file; nested maps become dotted keys, in the order of the file.
/// Throws InputError as `read_yaml` does, and if there is no setting.
std::vector<Assignment> read_assignments(const std::filesystem::path& file);

/// Reads "KEY=VALUE" as given to --set. Lists are written [a, b, c] or a,b,c.
/// Throws InputError if there is no '=' or no key.
Assignment parse_set_argument(std::string_view text);

/// The assignment a flag stands for: `--urdf robot.urdf` for `--set urdf=robot.urdf`.
Assignment flag_assignment(std::string_view flag, std::string_view value);

/// A flag without a value (`--stepping`), which only a yes-or-no setting accepts.
Assignment bare_flag_assignment(std::string_view flag);

}  // namespace saltus
