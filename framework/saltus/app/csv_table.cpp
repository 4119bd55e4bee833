#include "saltus/app/csv_table.hpp"

#include <fmt/format.h>

#include <iterator>

#include "saltus/core/error.hpp"

namespace saltus {

CsvTable::CsvTable(const std::vector<std::string>& columns) : columns_(columns.size()) {
  if (columns.empty()) throw DefinitionError("a CSV table needs at least one column");
  for (const std::string& name : columns) {
    if (name.empty() || name.find_first_of(",\"\r\n") != std::string::npos) {
      throw DefinitionError(fmt::format("'{}' cannot be the name of a CSV column", name));
    }
    text_ += (text_.empty() ? "" : ",") + name;
  }
  text_ += '\n';
}

void CsvTable::add_row(std::span<const double> row) {
  if (row.size() != columns_) {
    throw DefinitionError(
        fmt::format("a CSV row has {} numbers for {} columns", row.size(), columns_));
  }
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) text_ += ',';
    fmt::format_to(std::back_inserter(text_), "{}", row[i]);
  }
  text_ += '\n';
  ++rows_;
}

}  // namespace saltus
