// SPDX-License-Identifier: BSD-3-Clause
// Counts good and bad rows of one file, prints the bad ones, and decides when there are too many.
#pragma once

#include <cstdint>
#include <string>

#include "toolchain/import/importer.hpp"

namespace sortie::toolchain {

/// Judge of one import; files are judged one by one.
class RowJudge {
 public:
  /// Keeps references to both.
  RowJudge(const ImportOptions& options, ImportReport& report) : options_(options), report_(report) {}

  /// A new file begins.
  void begin(const std::string& path);
  /// A row was used.
  void good();
  /// A row of a sensor is dropped: counted, and printed ("place: dropped: reason"; at most 20 a file, then
  /// only a number). With `strict` throws InputError.
  void bad(const std::string& place, const std::string& reason);
  /// A row of truth has no usable reference: legal, counted.
  void hidden_truth() { ++report_.hidden_truth; }
  /// A stamp lies before the one above: reported, kept (the estimators judge it again).
  void time_backwards(const std::string& place, std::int64_t by_ns);
  /// The file breaks off at `offset`: a warning, with `strict` InputError.
  void cut_off(std::uint64_t offset, const std::string& what);
  /// A whole row of a kind that the importer has no use for: legal, counted.
  void other_row() { ++report_.other_rows; }
  /// A row whose stamp does not fit into the order of the rows: legal, counted.
  void out_of_order() { ++report_.out_of_order; }
  /// What became of the returns of a scan that is used.
  void returns(const ReturnCounts& scan) { report_.returns.add(scan); }
  /// A remark for the report.
  void warn(const std::string& text) { report_.warnings.push_back(text); }
  /// The file has been read. Throws InputError if the share of bad rows is above options.max_bad_rows, or if
  /// there is no row at all in a file that is `required`; without rows in another a warning.
  void finish(bool required);

  /// Rows of this file so far, good and bad.
  std::uint64_t rows() const { return good_ + bad_; }
  const ImportOptions& options() const { return options_; }

 private:
  std::ostream& notes() const;

  const ImportOptions& options_;
  ImportReport& report_;
  std::string path_;
  std::string first_bad_;
  std::string cut_;
  std::string first_backwards_;
  std::uint64_t good_{};
  std::uint64_t bad_{};
  std::uint64_t backwards_{};
};

}  // namespace sortie::toolchain
