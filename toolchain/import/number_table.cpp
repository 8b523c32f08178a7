// SPDX-License-Identifier: BSD-3-Clause
// Row-by-row checks: field count, numbers, finiteness, range, order of time.
#include "toolchain/import/number_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sortie::toolchain {
namespace {

/// Nothing that a robot measures is larger; squares of it stay finite.
constexpr double kLargest = 1e12;

std::string expected_row(const std::vector<std::string>& columns, const char* between) {
  std::string text;
  for (const std::string& column : columns) text += (text.empty() ? "" : between) + column;
  return text;
}

}  // namespace

NumberTable::NumberTable(const std::string& path, TableForm form, RowJudge& judge)
    : file_(path), form_(std::move(form)), judge_(judge), columns_(form_.stamps) {
  judge_.begin(path);
  columns_.insert(columns_.end(), form_.values.begin(), form_.values.end());
  numbers_.resize(columns_.size());
  stamps_.resize(columns_.size());
  if (form_.has_header) {
    find_columns();
  } else {
    for (std::size_t i = 0; i < columns_.size(); ++i) where_.push_back(i);
    extra_.assign(columns_.size(), false);
  }
}

void NumberTable::find_columns() {
  std::string_view line;
  const bool has_line = file_.next(line);
  if (has_line && line.substr(0, 3) == "\xEF\xBB\xBF")
    line.remove_prefix(3);  // byte order mark of some editors
  split(has_line ? line : std::string_view(), ',', names_);
  extra_.assign(names_.size(), true);
  for (const std::string& column : columns_) {
    const auto found = std::find(names_.begin(), names_.end(), std::string_view(column));
    if (found == names_.end()) {
      throw firmware::InputError(file_.path() + ":1: is not " + form_.what +
                                 ": its header row has no column '" + column + "' (expected " +
                                 expected_row(columns_, ",") + "; found " + quote(line) +
                                 "); check the path and the kind");
    }
    const auto index = static_cast<std::size_t>(found - names_.begin());
    where_.push_back(index);
    extra_[index] = false;
  }
}

bool NumberTable::parse_row(std::string_view line, std::string& fault) {
  split(line, form_.has_header ? ',' : ' ', fields_);
  if (fields_.size() != extra_.size()) {
    fault = std::to_string(fields_.size()) + " columns instead of " + std::to_string(extra_.size());
    return false;
  }
  for (std::size_t i = 0; i < where_.size(); ++i) {
    const std::string_view field = fields_[where_[i]];
    const std::string shown = "'" + columns_[i] + "' is " + quote(field);
    if (i < form_.stamps.size()) {
      if (!parse_seconds(field, stamps_[i])) return fault = shown + ", no time in seconds", false;
      if (stamps_[i] < -kFarthestStamp_ns || stamps_[i] > kFarthestStamp_ns)
        return fault = shown + ", more than 4.5e9 s from 0", false;
      continue;
    }
    const bool parsed = parse_double(field, numbers_[i]);
    if (form_.truth) {
      if (!parsed && !field.empty()) return fault = shown + ", no number", false;
      if (!parsed || !std::isfinite(numbers_[i])) numbers_[i] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    if (!parsed) return fault = shown + ", no number", false;
    if (!std::isfinite(numbers_[i])) return fault = shown + ", not finite", false;
    if (std::fabs(numbers_[i]) > kLargest) return fault = shown + ", beyond 1e12", false;
  }
  for (std::size_t i = 0; i < extra_.size(); ++i) {
    double value = 0.0;
    if (!extra_[i]) continue;
    const std::string shown = quote(names_[i]) + " is " + quote(fields_[i]);
    if (!parse_double(fields_[i], value)) return fault = shown + ", no number", false;
    if (!std::isfinite(value)) return fault = shown + ", not finite", false;
  }
  return true;
}

bool NumberTable::next(std::size_t time_column) {
  std::string_view line;
  std::string fault;
  while (file_.next(line)) {
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    if (!parse_row(line, fault)) {
      // A file without a header shows its kind only by the number of its columns.
      if (!form_.has_header && judge_.rows() == 0 && fields_.size() != extra_.size()) {
        throw firmware::InputError(file_.place() + ": is not " + form_.what + ": " + fault + " (" +
                                   expected_row(columns_, " ") + "); check the path and the kind");
      }
      judge_.bad(file_.place(), fault);
      continue;
    }
    judge_.good();
    const std::int64_t stamp = stamps_[time_column];
    if (latest_ns_ && stamp < *latest_ns_) judge_.time_backwards(file_.place(), *latest_ns_ - stamp);
    latest_ns_ = stamp;
    return true;
  }
  if (!file_.tail().empty()) {
    judge_.cut_off(file_.size() - file_.tail().size(), "the last row has no line end");
  }
  judge_.finish(!form_.truth);
  return false;
}

}  // namespace sortie::toolchain
