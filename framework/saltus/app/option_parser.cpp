#include "saltus/app/option_parser.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {

struct OptionParser::Cli {
  CLI::App app;
};

struct OptionParser::Declared {
  std::string flag, what;
  bool takes_value = true, is_repeated = false;
  CLI::Option* option = nullptr;
  Take take;
};

OptionParser::OptionParser(std::string command, std::string summary)
    : cli_(std::make_unique<Cli>()), command_(std::move(command)) {
  cli_->app.name("saltus " + command_);
  cli_->app.description(std::move(summary));
  cli_->app.set_help_flag();  // --help is an ordinary flag, so that the caller prints it
  cli_->app.allow_extras();
  flag("--help,-h", "print this help", help_wanted_);
}

OptionParser::~OptionParser() = default;

OptionParser& OptionParser::declare(const std::string& flag, const std::string& what,
                                    const std::string& doc, bool is_repeated, Take take) {
  CLI::Option* option = cli_->app.add_option(
      flag, [](const CLI::results_t&) { return true; }, doc);
  option->type_name(what)->expected(1)->allow_extra_args(false);
  option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  declared_.push_back({flag, what, true, is_repeated, option, std::move(take)});
  return *this;
}

OptionParser& OptionParser::option(const std::string& flag, const std::string& what,
                                   const std::string& doc, Take take) {
  return declare(flag, what, doc, false, std::move(take));
}

OptionParser& OptionParser::option(const std::string& flag, const std::string& what,
                                   const std::string& doc, std::string& field) {
  return declare(flag, what, doc, false, [&field](const std::string& value) { field = value; });
}

OptionParser& OptionParser::repeated(const std::string& flag, const std::string& what,
                                     const std::string& doc, Take take) {
  return declare(flag, what, doc, true, std::move(take));
}

OptionParser& OptionParser::flag(const std::string& flag, const std::string& doc, bool& field) {
  CLI::Option* option = cli_->app.add_flag(flag, doc);
  declared_.push_back({flag.substr(0, flag.find(',')), "", false, flag.starts_with("--help"),
                       option, [&field](const std::string&) { field = true; }});
  return *this;
}

OptionParser& OptionParser::word(const std::string& name, const std::string& doc,
                                 std::string& field) {
  word_name_ = name;
  word_ = &field;
  cli_->app.add_option(name, field, doc)->type_name("");
  return *this;
}

OptionParser& OptionParser::others(TakeOther take) {
  others_ = std::move(take);
  return *this;
}

const OptionParser::Declared* OptionParser::find(std::string_view flag) const {
  const auto it = std::find_if(declared_.begin(), declared_.end(),
                               [&](const Declared& d) { return d.flag == flag; });
  return it == declared_.end() ? nullptr : &*it;
}

// CLI11 would take the word after an unknown flag for a positional argument, and the flag after an
// option for its value. Therefore each flag is joined with its value in one word.
std::vector<std::string> OptionParser::with_values_attached(
    std::span<const std::string> words) const {
  std::vector<std::string> attached;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (!word.starts_with("--") || word.size() == 2) {
      if (word.starts_with("-") && word != "-h") reject(word);
      attached.push_back(word);
      continue;
    }
    const auto equals = word.find('=');
    const std::string flag = word.substr(0, equals);
    const Declared* known = find(flag);
    if (known == nullptr && !others_) reject(flag);
    const bool is_switch = known != nullptr && !known->takes_value;
    if (is_switch && equals != std::string::npos)
      throw InputError(fmt::format("{} takes no value, but '{}' follows", flag,
                                   shortened(word.substr(equals + 1))));
    std::string whole = word;
    if (!is_switch && equals == std::string::npos && i + 1 < words.size() &&
        !words[i + 1].starts_with("--"))
      whole += "=" + words[++i];
    if (known != nullptr && known->takes_value && whole.size() <= flag.size() + 1)
      throw InputError(fmt::format("{} needs a value: {} {}", flag, flag, known->what));
    attached.push_back(std::move(whole));
  }
  return attached;
}

void OptionParser::parse(std::span<const std::string> words) {
  const std::vector<std::string> attached = with_values_attached(words);
  try {
    cli_->app.parse(std::vector<std::string>(attached.rbegin(),
                                             attached.rend()));  // CLI11 takes words from the back
  } catch (const CLI::ParseError& error) {
    throw InputError(shortened(error.what()));
  }
  for (const Declared& d : declared_)
    if (!d.is_repeated && d.option->count() > 1)
      throw InputError(fmt::format("{} is given twice", d.flag));
  for (const std::string& word : cli_->app.remaining()) {
    if (word.starts_with("--") && word.size() > 2) continue;
    if (word_ == nullptr || word_->empty()) reject(word);
    throw InputError(fmt::format("one {} at a time: '{}' or '{}'?", word_name_, shortened(*word_),
                                 shortened(word)));
  }
  for (const std::string& word : attached) hand_over(word);  // in order
}

bool OptionParser::prints_help(std::span<const std::string> words) {
  parse(words);
  if (help_wanted_) fmt::print("{}", help());
  return help_wanted_;
}

void OptionParser::hand_over(const std::string& word) const {
  if (word == "-h") return hand_over("--help");
  // a positional argument, which CLI11 has stored
  if (!word.starts_with("--") || word.size() == 2) return;
  const auto equals = word.find('=');
  const std::string flag = word.substr(0, equals);
  std::optional<std::string> value;
  if (equals != std::string::npos) value = word.substr(equals + 1);
  if (const Declared* known = find(flag))
    known->take(value.value_or(""));
  else
    others_(flag.substr(2), value);
}

void OptionParser::reject(const std::string& word) const {
  if (!word.starts_with("-"))
    throw InputError(fmt::format("'{}' is not understood; usage: {}", shortened(word), usage()));
  if (!word.starts_with("--") && others_)
    throw InputError(
        fmt::format("unknown flag '{}'; flags begin with two dashes", shortened(word)));
  std::vector<std::string> flags;
  for (const Declared& d : declared_) flags.push_back(d.flag);
  const std::string meant = nearest_name(word, flags);
  throw InputError(
      meant.empty() ? fmt::format("'{}' is not understood; usage: {}", shortened(word), usage())
                    : fmt::format("unknown flag '{}'; did you mean '{}'?", shortened(word), meant));
}

std::string OptionParser::usage() const {
  std::string text = command_;
  if (word_ != nullptr) text += " " + word_name_;
  for (const Declared& d : declared_) {
    if (d.flag == "--help") continue;
    text += fmt::format(" [{}{}]{}", d.flag, d.what.empty() ? "" : " " + d.what,
                        d.is_repeated ? "..." : "");
  }
  return text;
}

std::string OptionParser::help() const { return cli_->app.help(); }

}  // namespace saltus
