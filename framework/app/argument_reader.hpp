// Words of a command line, read one after the other.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// Takes arguments apart into words and flags. The value of a flag follows it as "--flag=value" or
/// as the next argument. Every mistake throws InputError, one sentence.
class ArgumentReader {
 public:
  explicit ArgumentReader(std::span<const std::string> arguments) : rest_(arguments) {}

  bool at_end() const { return rest_.empty(); }

  /// The next argument; of "--flag=value" only the flag, and the value is kept.
  std::string next();
  /// The value of the flag that next() returned, if it has one.
  std::optional<std::string> take_value();
  /// A value that may not be missing or empty; `what` says what it is: "FILE".
  std::string require_value(std::string_view what);
  /// For flags that are a word of their own: "--flag=value" is refused.
  void refuse_value() const;
  /// Refuses the flag that next() returned if it was announced before.
  void once();
  /// The argument that next() returned is none of `flags`.
  [[noreturn]] void reject(const std::vector<std::string>& flags, std::string_view usage) const;

 private:
  std::span<const std::string> rest_;
  std::string word_;
  std::optional<std::string> value_;
  std::vector<std::string> seen_;
};

}  // namespace saltus
