// A table of numbers as text that reads back exactly.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace saltus {

/// Comma-separated values with one header line ("t,com_x,com_y"). Each number has the fewest digits
/// from which the same double is read again.
class CsvTable {
 public:
  /// Throws DefinitionError if there is no column, or a name is empty or holds a comma, a quote or
  /// a line break.
  explicit CsvTable(const std::vector<std::string>& columns);

  /// Throws DefinitionError unless there is one number per column.
  void add_row(std::span<const double> row);

  /// How many columns were named.
  std::size_t columns() const { return columns_; }
  /// How many rows are complete.
  std::size_t rows() const { return rows_; }
  /// The whole table as CSV, with its line of names.
  const std::string& text() const { return text_; }

 private:
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  std::string text_;
};

}  // namespace saltus
