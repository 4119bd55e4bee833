#include "saltus/app/argument_reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {

std::string ArgumentReader::next() {
  word_ = rest_.front();
  rest_ = rest_.subspan(1);
  value_.reset();
  const auto equals = word_.find('=');
  if (word_.starts_with("--") && equals != std::string::npos) {
    value_ = word_.substr(equals + 1);
    word_.resize(equals);
  }
  return word_;
}

std::optional<std::string> ArgumentReader::take_value() {
  if (!value_ && !rest_.empty() && !rest_.front().starts_with("--")) {
    value_ = rest_.front();
    rest_ = rest_.subspan(1);
  }
  return std::move(value_);
}

std::string ArgumentReader::require_value(std::string_view what) {
  const std::optional<std::string> value = take_value();
  if (!value || value->empty())
    throw InputError(fmt::format("{} needs a value: {} {}", word_, word_, what));
  return *value;
}

void ArgumentReader::refuse_value() const {
  if (value_) throw InputError(fmt::format("{} takes no value, but '{}' follows", word_, *value_));
}

void ArgumentReader::once() {
  if (std::find(seen_.begin(), seen_.end(), word_) != seen_.end())
    throw InputError(fmt::format("{} is given twice", word_));
  seen_.push_back(word_);
}

void ArgumentReader::reject(const std::vector<std::string>& flags, std::string_view usage) const {
  const std::string meant = word_.starts_with("-") ? nearest_name(word_, flags) : std::string();
  throw InputError(meant.empty()
                       ? fmt::format("'{}' is not understood; usage: {}", word_, usage)
                       : fmt::format("unknown flag '{}'; did you mean '{}'?", word_, meant));
}

}  // namespace saltus
