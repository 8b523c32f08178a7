// SPDX-License-Identifier: BSD-3-Clause
// One bad row is a nuisance, one in five is another file: where the line between them is drawn.
#include "toolchain/import/row_judge.hpp"

#include <iostream>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {
namespace {

constexpr std::uint64_t kPrintedRows = 20;

}  // namespace

std::ostream& RowJudge::notes() const { return options_.notes != nullptr ? *options_.notes : std::cerr; }

void RowJudge::begin(const std::string& path) {
  path_ = path;
  first_bad_.clear();
  cut_.clear();
  first_backwards_.clear();
  good_ = bad_ = backwards_ = 0;
  report_.sources.push_back(path);
}

void RowJudge::good() {
  ++good_;
  ++report_.rows;
}

void RowJudge::bad(const std::string& place, const std::string& reason) {
  if (options_.strict)
    throw firmware::InputError(place + ": " + reason + "; repair the row, or leave --strict out to drop it");
  if (bad_ == 0) first_bad_ = place + ": " + reason;
  ++bad_;
  ++report_.rows;
  ++report_.bad_rows;
  if (bad_ <= kPrintedRows) notes() << place << ": dropped: " << reason << '\n';
}

void RowJudge::time_backwards(const std::string& place, std::int64_t by_ns) {
  if (backwards_ == 0)
    first_backwards_ = place + ": time runs back by " + firmware::format_seconds(by_ns) + " s";
  ++backwards_;
  ++report_.time_backwards;
}

void RowJudge::cut_off(std::uint64_t offset, const std::string& what) {
  const std::string text = path_ + ": breaks off at byte " + std::to_string(offset) + " (" + what + ")";
  if (options_.strict)
    throw firmware::InputError(text + "; copy the file again, or leave --strict out to use what is whole");
  warn(text + "; everything whole before it was used");
  cut_ = ", it breaks off at byte " + std::to_string(offset);
}

void RowJudge::finish(bool required) {
  if (rows() == 0) {
    const std::string text = path_ + ": holds no whole row of data" + cut_;
    if (required) throw firmware::InputError(text + "; check that the file is whole");
    warn(text);
  }
  if (bad_ > kPrintedRows) notes() << path_ << ": dropped: " << bad_ - kPrintedRows << " more rows\n";
  if (backwards_ > 0)
    warn(first_backwards_ + " (" + std::to_string(backwards_) + " such rows in the file, kept)");
  const double share = rows() > 0 ? static_cast<double>(bad_) / static_cast<double>(rows()) : 0.0;
  if (share > options_.max_bad_rows) {
    throw firmware::InputError(path_ + ": " + std::to_string(bad_) + " of " + std::to_string(rows()) +
                               " rows are bad (" + firmware::format_fixed(100.0 * share, 1) + " %, at most " +
                               firmware::format_fixed(100.0 * options_.max_bad_rows, 0) +
                               " % may be dropped); first " + first_bad_ +
                               "; repair the file or record it again");
  }
}

}  // namespace sortie::toolchain
