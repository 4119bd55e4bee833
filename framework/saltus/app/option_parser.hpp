// Command-line options with CLI11. Values are written --flag VALUE or --flag=VALUE. Every error is
// reported in one sentence.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// Declares the options of a command and parses its arguments. A value may start with one dash
/// ("-2") but not with two. Options may be given once unless declared as repeated.
///
///     OptionParser parser("suite", "every problem of the library against its known answer");
///     parser.option("--only", "PATTERN", "part of an id or name", request.only);
///     parser.parse(words);
class OptionParser {
 public:
  /// Receives the value of a flag. Throws InputError if the value is invalid.
  using Take = std::function<void(const std::string& value)>;
  /// Receives an undeclared flag without its dashes, and its value if one follows.
  using TakeOther =
      std::function<void(const std::string& flag, const std::optional<std::string>& value)>;

  /// `command` as the user types it, for messages; `summary` is the first line of the help.
  OptionParser(std::string command, std::string summary);
  ~OptionParser();

  /// An option with a value. `what` names the value in help and messages ("FILE"). Empty values are
  /// rejected.
  OptionParser& option(const std::string& flag, const std::string& what, const std::string& doc,
                       Take take);
  /// An option with a value, stored in `field`.
  OptionParser& option(const std::string& flag, const std::string& what, const std::string& doc,
                       std::string& field);
  /// An option that may be repeated.
  OptionParser& repeated(const std::string& flag, const std::string& what, const std::string& doc,
                         Take take);
  /// A flag without a value; sets the field to true.
  OptionParser& flag(const std::string& flag, const std::string& doc, bool& field);
  /// A positional argument. Without one, positional arguments are rejected.
  OptionParser& word(const std::string& name, const std::string& doc, std::string& field);
  /// Passes undeclared flags to `take` in order instead of rejecting them.
  OptionParser& others(TakeOther take);

  /// Parses the arguments. Throws InputError for unknown flags (with the nearest known one),
  /// missing or superfluous values, repeated options and unexpected arguments. In these cases no
  /// option has been stored. A `take` may also throw InputError.
  void parse(std::span<const std::string> words);
  /// Parses the arguments. Prints the help and returns true if --help or -h was given.
  bool prints_help(std::span<const std::string> words);
  /// True if --help or -h was given.
  bool help_wanted() const { return help_wanted_; }
  /// Command, summary and one line per option.
  std::string help() const;

 private:
  struct Declared;
  OptionParser& declare(const std::string& flag, const std::string& what, const std::string& doc,
                        bool is_repeated, Take take);
  const Declared* find(std::string_view flag) const;
  std::vector<std::string> with_values_attached(std::span<const std::string> words) const;
  void hand_over(const std::string& word) const;
  [[noreturn]] void reject(const std::string& word) const;
  std::string usage() const;

  struct Cli;
  std::unique_ptr<Cli> cli_;
  std::string command_;
  std::vector<Declared> declared_;
  std::string word_name_;
  std::string* word_ = nullptr;
  TakeOther others_;
  bool help_wanted_ = false;
};

}  // namespace saltus
