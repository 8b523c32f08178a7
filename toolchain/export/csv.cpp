// SPDX-License-Identifier: BSD-3-Clause
// Plain CSV: comma, LF, decimal point, no quotes needed.
#include "toolchain/export/csv.hpp"

#include <ostream>
#include <stdexcept>

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

void CsvWriter::begin(std::int64_t time_ns) {
  out_ << firmware::format_seconds(time_ns);
  written_ = 0;
}

void CsvWriter::put(const std::string& text) {
  out_ << ',' << text;
  ++written_;
}

void CsvWriter::end() {
  out_ << '\n';
  ++rows_;
  if (written_ != columns_) {
    throw std::invalid_argument("csv: a row of " + std::to_string(written_) + " values under " +
                                std::to_string(columns_) + " columns");
  }
}

void CsvWriter::row(std::int64_t time_ns, const std::vector<double>& values) {
  begin(time_ns);
  for (const double value : values) field(value);
  end();
}

}  // namespace sortie::toolchain
