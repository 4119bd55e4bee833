// A table of numbers as text that reads back exactly.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace saltus {

/// Comma-separated values with one header line ("t,com_x,com_y"). Numbers have the fewest digits
/// that give the same double when read.
class CsvTable {
 public:
  /// Throws DefinitionError if there is no column, or a name is empty or contains a comma, a quote
  /// or a line break.
  explicit CsvTable(const std::vector<std::string>& columns);

  /// Throws DefinitionError unless there is one number per column.
  void add_row(std::span<const double> row);

  /// Number of columns.
  std::size_t columns() const { return columns_; }
  /// Number of complete rows.
  std::size_t rows() const { return rows_; }
  /// The whole table as CSV, including the header.
  const std::string& text() const { return text_; }

 private:
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  std::string text_;
};

}  // namespace saltus
