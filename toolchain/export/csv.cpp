// SPDX-License-Identifier: BSD-3-Clause
// Plain CSV: comma, LF, decimal point, no quotes needed.
#include "toolchain/export/csv.hpp"

#include <ostream>
#include <stdexcept>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

CsvWriter::CsvWriter(std::ostream& out, const std::vector<std::string>& columns)
    : out_(out), columns_(columns.size()) {
  out_ << "time";
  for (const std::string& column : columns) {
    out_ << ',';
    for (const char c : column)
      out_ << (c == ',' || c == ':' || c == '"' || c == '\n' || c == '\r' ? '_' : c);
  }
  out_ << '\n';
}

void CsvWriter::row(std::int64_t time_ns, const std::vector<double>& values) {
  out_ << firmware::format_seconds(time_ns);
  for (const double value : values) out_ << ',' << (value == value ? firmware::format_exact(value) : "");
  out_ << '\n';
  if (values.size() != columns_) {
    throw std::invalid_argument("csv: a row of " + std::to_string(values.size()) + " values under " +
                                std::to_string(columns_) + " columns");
  }
}

}  // namespace sortie::toolchain
