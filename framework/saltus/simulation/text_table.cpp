#include "saltus/simulation/text_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

std::string csv_word(std::string_view value) {
  if (value.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(value);
  std::string quoted = "\"";
  for (const char c : value) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

TextTable::TextTable(const std::vector<std::string>& columns) : columns_(columns.size()) {
  for (const std::string& name : columns) word(name);
  end_row();
}

void TextTable::begin_cell() {
  if (cells_ == columns_)
    throw DefinitionError(fmt::format("a row has more than {} cells", columns_));
  if (cells_++ > 0) text_ += ',';
}

TextTable& TextTable::number(double value) {
  begin_cell();
  if (!std::isnan(value)) fmt::format_to(std::back_inserter(text_), "{}", value);
  return *this;
}

TextTable& TextTable::integer(long value) {
  begin_cell();
  fmt::format_to(std::back_inserter(text_), "{}", value);
  return *this;
}

TextTable& TextTable::word(std::string_view value) {
  begin_cell();
  text_ += csv_word(value);
  return *this;
}

TextTable& TextTable::empty() {
  begin_cell();
  return *this;
}

void TextTable::end_row() {
  while (cells_ < columns_) empty();
  cells_ = 0;
  text_ += '\n';
}

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + '"';
}

std::string json_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string("null");
}

}  // namespace saltus
