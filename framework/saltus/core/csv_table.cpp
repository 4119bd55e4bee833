#include "saltus/core/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "saltus/core/error.hpp"

namespace saltus {

CsvTable::CsvTable(const std::vector<std::string>& columns) : columns_(columns.size()) {
  if (columns.empty()) throw DefinitionError("a CSV table needs at least one column");
  for (const std::string& name : columns) {
    if (name.empty()) throw DefinitionError("'' cannot be the name of a CSV column");
    word(name);
  }
  end_row();
  rows_ = 0;
}

std::string& CsvTable::begin_cell() {
  if (cells_ == columns_)
    throw DefinitionError(fmt::format("a row has more than {} cells", columns_));
  if (cells_++ > 0) text_ += ',';
  return text_;
}

CsvTable& CsvTable::number(double value) {
  if (std::isnan(value))
    begin_cell() += "nan";  // the sign of NaN has no meaning
  else
    fmt::format_to(std::back_inserter(begin_cell()), "{}", value);
  return *this;
}

CsvTable& CsvTable::integer(long value) {
  fmt::format_to(std::back_inserter(begin_cell()), "{}", value);
  return *this;
}

CsvTable& CsvTable::word(std::string_view value) {
  std::string& text = begin_cell();
  if (value.find_first_of(",\"\r\n") == std::string_view::npos) {
    text += value;
    return *this;
  }
  text += '"';
  for (const char c : value) text.append(c == '"' ? 2 : 1, c);
  text += '"';
  return *this;
}

CsvTable& CsvTable::empty() {
  begin_cell();
  return *this;
}

CsvTable& CsvTable::numbers(std::span<const double> values, std::size_t columns) {
  for (std::size_t i = 0; i < columns; ++i) i < values.size() ? number(values[i]) : empty();
  return *this;
}

void CsvTable::end_row() {
  while (cells_ < columns_) empty();
  cells_ = 0;
  text_ += '\n';
  ++rows_;
}

void CsvTable::add_row(std::span<const double> row) {
  if (row.size() != columns_)
    throw DefinitionError(
        fmt::format("a CSV row has {} numbers for {} columns", row.size(), columns_));
  numbers(row, columns_).end_row();
}

std::vector<std::string> csv_cells(std::string_view line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && is_quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += line[i++];
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

}  // namespace saltus
