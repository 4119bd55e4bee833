// Tables of numbers and words as CSV, and JSON strings: what logs are written with.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// Comma-separated values with one header line. Numbers have the fewest digits from which the same
/// double is read again, what is not a number is an empty cell, words are quoted where they must.
class TextTable {
 public:
  /// The first line.
  explicit TextTable(const std::vector<std::string>& columns);

  // Cells of the present row, from left to right. A row that is ended early is filled up with
  // empty cells; more cells than columns throw DefinitionError.
  /// With 17 digits, so that it reads back the same.
  TextTable& number(double value);
  /// A whole number.
  TextTable& integer(long value);
  /// A text; quoted if it must be.
  TextTable& word(std::string_view value);
  /// Nothing.
  TextTable& empty();
  /// Ends the row; what is missing in it stays empty.
  void end_row();

  /// What was written so far.
  const std::string& text() const { return text_; }

 private:
  void begin_cell();

  std::size_t columns_, cells_ = 0;
  std::string text_;
};

/// The text as a string of JSON, with its quotes.
std::string json_string(std::string_view text);
/// The number as JSON, which has no word for what is not finite: null.
std::string json_number(double value);

}  // namespace saltus
