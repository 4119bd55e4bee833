// Tables as comma-separated values, in the only dialect that Saltus writes and reads.
//
// The first line names the columns. A number has the fewest digits that give the same double when
// read back. NaN and infinities are written nan, inf and -inf. An empty cell is a missing value. A
// word with a comma, a quote or a line break is quoted, and quotes in it are doubled.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// A table that is written cell by cell or row by row.
class CsvTable {
 public:
  /// Throws DefinitionError if there is no column or a name is empty.
  explicit CsvTable(const std::vector<std::string>& columns);

  // Cells of the current row, from left to right. More cells than columns throw DefinitionError.
  /// A number.
  CsvTable& number(double value);
  /// An integer.
  CsvTable& integer(long value);
  /// A text.
  CsvTable& word(std::string_view value);
  /// A missing value.
  CsvTable& empty();
  /// The first numbers of a vector, and empty cells for the columns that it does not have.
  CsvTable& numbers(std::span<const double> values, std::size_t columns);
  /// Ends the row. Missing cells are empty.
  void end_row();
  /// A row of numbers. Throws DefinitionError unless there is one number per column.
  void add_row(std::span<const double> row);

  /// Number of columns.
  std::size_t columns() const { return columns_; }
  /// Number of complete rows.
  std::size_t rows() const { return rows_; }
  /// The whole table as CSV, with its line of names.
  const std::string& text() const { return text_; }

 private:
  std::string& begin_cell();

  std::size_t columns_ = 0, cells_ = 0, rows_ = 0;
  std::string text_;
};

/// Deprecated name.
using TextTable [[deprecated("use CsvTable; removed in 0.4")]] = CsvTable;

/// Cells of a line of CSV, without quotes.
std::vector<std::string> csv_cells(std::string_view line);

}  // namespace saltus
