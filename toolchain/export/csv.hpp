// SPDX-License-Identifier: BSD-3-Clause
// Series of any described struct as CSV for PlotJuggler, pandas and gnuplot. First column: time in seconds.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "firmware_like/scene/text_format.hpp"
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
  /// One row of a described struct; its columns must have come from csv_columns<T>().
  template <rt::Described T>
  void row(std::int64_t time_ns, const T& value) {
    begin(time_ns);
    rt::for_each_scalar(value, [this](const char*, int, auto scalar) { this->field(scalar); });
    end();
  }
  /// Rows written.
  std::uint64_t rows() const { return rows_; }

 private:
  void begin(std::int64_t time_ns);
  void put(const std::string& text);
  void end();
  /// Integers keep all their digits.
  template <class T>
  void field(T value) {
    if constexpr (std::is_floating_point_v<T>) {
      put(value == value ? firmware::format_exact(value) : std::string());
    } else if constexpr (std::is_signed_v<T>) {
      put(std::to_string(static_cast<std::int64_t>(value)));
    } else {
      put(std::to_string(static_cast<std::uint64_t>(value)));
    }
  }

  std::ostream& out_;
  std::size_t columns_;
  std::size_t written_{};
  std::uint64_t rows_{};
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
