// SPDX-License-Identifier: BSD-3-Clause
// A table of numbers in a text file: columns found by name (with a header row) or by place (without), every
// row checked.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "toolchain/import/row_judge.hpp"
#include "toolchain/import/text_file.hpp"

namespace sortie::toolchain {

/// How the file should look, and which of its columns the reader needs.
struct TableForm {
  const char* what;                 ///< for messages: "the IMU file of a husky set"
  std::vector<std::string> stamps;  ///< columns in seconds within +-4.5e9, read exactly to the nanosecond
  std::vector<std::string> values;  ///< columns of numbers, finite and below 1e12
  bool has_header{true};  ///< comma-separated with a header row; otherwise blanks and columns by place
  bool truth{false};      ///< values are a reference: empty, NaN or infinite is legal and becomes NaN, and
                          ///< without a row the import goes on
};

/// Reads row by row. A bad row goes to the judge and is stepped over. With a header, columns that nobody
/// needs must still be numbers: a damaged row is damaged wherever the damage sits.
class NumberTable {
 public:
  /// Opens the file and checks its first row. Throws InputError for a wrong kind of file: what was expected
  /// and found.
  NumberTable(const std::string& path, TableForm form, RowJudge& judge);

  /// The next usable row; false at the end, when the judge has also given its verdict (may throw InputError).
  /// `time_column` (the index of a stamp) is watched for stamps that run backwards.
  bool next(std::size_t time_column);

  /// Values of the row, by index among TableForm's stamps and, behind them, its values.
  double number(std::size_t column) const { return numbers_[column]; }
  std::int64_t nanoseconds(std::size_t column) const { return stamps_[column]; }
  /// "file:line" of the row.
  std::string place() const { return file_.place(); }

 private:
  void find_columns();
  bool parse_row(std::string_view line, std::string& fault);

  TextFile file_;
  TableForm form_;
  RowJudge& judge_;
  std::vector<std::string> columns_;  ///< stamps, then values
  std::vector<std::size_t> where_;    ///< field number of each needed column
  std::vector<bool> extra_;           ///< fields that nobody needs
  std::vector<std::string_view> names_;
  std::vector<std::string_view> fields_;
  std::vector<double> numbers_;
  std::vector<std::int64_t> stamps_;
  std::optional<std::int64_t> latest_ns_;
};

}  // namespace sortie::toolchain
