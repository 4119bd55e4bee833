// Writes logs: CSV tables of numbers and text, and JSON strings.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// Comma-separated values with one header line. Numbers have the fewest digits that give the same
/// double when read. NaN and infinity give empty cells. Text is quoted if necessary.
class TextTable {
 public:
  /// Writes the header line.
  explicit TextTable(const std::vector<std::string>& columns);

  // Cells of the current row, from left to right. Missing cells at the end of a row stay empty; too
  // many cells throw DefinitionError.
  /// A number that reads back exactly.
  TextTable& number(double value);
  /// An integer.
  TextTable& integer(long value);
  /// A text, quoted if necessary.
  TextTable& word(std::string_view value);
  /// An empty cell.
  TextTable& empty();
  /// Ends the row. Missing cells stay empty.
  void end_row();

  /// The table so far.
  const std::string& text() const { return text_; }

 private:
  void begin_cell();

  std::size_t columns_, cells_ = 0;
  std::string text_;
};

/// The text as a JSON string with quotes.
std::string json_string(std::string_view text);
/// The number as JSON; null if it is not finite.
std::string json_number(double value);

}  // namespace saltus
