// The options of a command line, by CLI11, with values that are written --flag VALUE or
// --flag=VALUE, and with every mistake as one sentence.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// Declares what a command understands, then takes its words apart. A value may begin with one dash
/// ("-2") but not with two; options are given once unless they are declared as repeated.
///
///     OptionParser parser("suite", "every problem of the library against its known answer");
///     parser.option("--only", "PATTERN", "part of an id or name", request.only);
///     parser.parse(words);
class OptionParser {
 public:
  /// Takes the word after a flag; throws InputError if it is none of what the flag takes.
  using Take = std::function<void(const std::string& value)>;
  /// Of what is not declared: a flag without its dashes, and its value if one follows.
  using TakeOther =
      std::function<void(const std::string& flag, const std::optional<std::string>& value)>;

  /// `command` as the user types it, for messages; `summary` is the first line of the help.
  OptionParser(std::string command, std::string summary);
  ~OptionParser();

  /// `what` names the value in help and messages ("FILE"); an empty value is refused.
  OptionParser& option(const std::string& flag, const std::string& what, const std::string& doc,
                       Take take);
  /// A flag with a word after it, `--flag WHAT`.
  OptionParser& option(const std::string& flag, const std::string& what, const std::string& doc,
                       std::string& field);
  /// The same, given as often as one likes.
  OptionParser& repeated(const std::string& flag, const std::string& what, const std::string& doc,
                         Take take);
  /// A flag without a word: sets the field.
  OptionParser& flag(const std::string& flag, const std::string& doc, bool& field);
  /// A word that belongs to no option. Without one every such word is refused.
  OptionParser& word(const std::string& name, const std::string& doc, std::string& field);
  /// Flags that are not declared are handed over, in their order, instead of being refused.
  OptionParser& others(TakeOther take);

  /// Throws InputError: unknown flags with the nearest known one, missing or superfluous values,
  /// what is given twice, words that nobody takes. Then no option has been handed over; a `take`
  /// may throw it too.
  void parse(std::span<const std::string> words);
  /// Whether --help (-h) was among the words.
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
