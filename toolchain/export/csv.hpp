// SPDX-License-Identifier: BSD-3-Clause
// Series of numbers as CSV for PlotJuggler, pandas and gnuplot. First column: time in seconds.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "rt/fields.hpp"

namespace sortie::toolchain {

/// Writes a header row once, then rows. Numbers read back as the same doubles; a NaN is an empty field.
class CsvWriter {
 public:
  /// `columns` without the time; commas, quotes and colons in names become '_' (PlotJuggler takes colons for
  /// times).
  CsvWriter(std::ostream& out, const std::vector<std::string>& columns);

  /// One row. Throws std::invalid_argument if `values` has another length than the header.
  void row(std::int64_t time_ns, const std::vector<double>& values);

 private:
  std::ostream& out_;
  std::size_t columns_;
};

/// Column names of a described struct: "name", or "name_0", "name_1" for arrays.
template <rt::Described T>
std::vector<std::string> csv_columns() {
  std::vector<std::string> names;
  rt::for_each_scalar(T{}, [&names](const char* name, int index, auto) {
    names.push_back(index < 0 ? std::string(name) : std::string(name) + "_" + std::to_string(index));
  });
  return names;
}

}  // namespace sortie::toolchain
