// SPDX-License-Identifier: BSD-3-Clause
// CARMEN logs: a planar laser and the pose that the wheels have summed up, row by row as the logger got them.
#include <algorithm>
#include <map>
#include <optional>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/import/carmen_row.hpp"
#include "toolchain/import/data_set.hpp"
#include "toolchain/import/kinds.hpp"
#include "toolchain/import/odometry_steps.hpp"
#include "toolchain/import/text_file.hpp"

namespace sortie::toolchain {
namespace {

/// A stamp that lies so far ahead of the rows on both sides is none.
constexpr rt::Nanoseconds kWild = 60 * rt::kNanosecondsPerSecond;
constexpr std::size_t kNamesShown = 8;

struct Row {
  CarmenRow content;
  bool laser{};
  std::string place;
};

/// Rows that are passed over, by name.
class PassedOver {
 public:
  void note(std::string_view name) {
    const auto found = counts_.find(name);
    if (found != counts_.end()) {
      ++found->second;
    } else if (counts_.size() < kNamesShown) {
      counts_.emplace(name, std::uint64_t{1});
    } else {
      ++more_;
    }
  }
  /// Empty if there was none.
  std::string text() const {
    std::string list;
    for (const auto& [name, count] : counts_)
      list += (list.empty() ? "" : ", ") + name + " " + std::to_string(count);
    return more_ > 0 ? list + ", others " + std::to_string(more_) : list;
  }

 private:
  std::map<std::string, std::uint64_t, std::less<>> counts_;
  std::uint64_t more_{};
};

std::string find_log(const std::string& path) {
  std::vector<std::string> found = find_files(path, ".clf");
  if (found.empty()) found = find_files(path, ".log");
  if (found.empty()) throw firmware::InputError(path + ": holds no *.clf and no *.log; give a CARMEN log");
  if (found.size() > 1)
    throw firmware::InputError(
        path + ": holds " + std::to_string(found.size()) + " CARMEN logs; name one of them: " + found.front(),
        2);
  return found.front();
}

/// Throws for a file without a row that could be used: then its lines are no rows of a log at all.
void check_kind(const std::string& path) {
  TextFile file(path);
  std::string_view line;
  while (file.next(line)) {
    for (const char* name : {"ODOM ", "FLASER ", "ROBOTLASER1 "}) {
      if (line.starts_with(name)) return;
    }
  }
  throw firmware::InputError(path + ": is no CARMEN log: none of its " + std::to_string(file.line_number()) +
                             " lines begins with ODOM, FLASER or ROBOTLASER1; check the path and the kind");
}

std::vector<Row> read_rows(const std::string& path, CarmenReader& reader, RowJudge& judge) {
  TextFile file(path);
  judge.begin(path);
  std::vector<Row> rows;
  PassedOver others;
  std::string_view line;
  std::string fault;
  CarmenRow row;
  while (file.next(line)) {
    switch (reader.read(line, row, fault)) {
      case CarmenLine::nothing:
        break;
      case CarmenLine::bad:
        judge.bad(file.place(), fault);
        break;
      case CarmenLine::other:
        judge.other_row();
        others.note(reader.name());
        break;
      case CarmenLine::odometry:
        rows.push_back({std::move(row), false, file.place()});
        break;
      case CarmenLine::laser:
        rows.push_back({std::move(row), true, file.place()});
        break;
    }
  }
  if (!file.tail().empty()) judge.cut_off(file.size() - file.tail().size(), "the last row has no line end");
  if (!others.text().empty()) judge.warn(path + ": rows of kinds that are not used: " + others.text());
  return rows;
}

/// Takes out rows whose stamp is a minute or more ahead of the row before and of the row after: one of them
/// would make all that follow look late.
void drop_wild(std::vector<Row>& rows, RowJudge& judge) {
  std::vector<Row> kept;
  kept.reserve(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const rt::Nanoseconds stamp_ns = rows[i].content.stamp_ns;
    const bool before = kept.empty() || stamp_ns >= kept.back().content.stamp_ns + kWild;
    const bool after = i + 1 < rows.size() && stamp_ns >= rows[i + 1].content.stamp_ns + kWild;
    if (before && after) {
      judge.bad(rows[i].place, "its stamp lies " +
                                   firmware::format_seconds(stamp_ns - rows[i + 1].content.stamp_ns) +
                                   " s ahead of the rows around it");
    } else {
      judge.good();
      kept.push_back(std::move(rows[i]));
    }
  }
  rows = std::move(kept);
}

/// Receipts follow the rows, also where stamps run back: what the logger got first comes first.
void add_rows(std::vector<Row>& rows, RowJudge& judge, LogBuilder& builder) {
  const bool has_odometry = std::any_of(rows.begin(), rows.end(), [](const Row& row) { return !row.laser; });
  OdometrySteps odometry(builder);
  rt::Nanoseconds receipt_ns = 0;
  std::optional<rt::Nanoseconds> above_ns[2];
  for (Row& row : rows) {
    const CarmenRow& at = row.content;
    receipt_ns = std::max(receipt_ns, at.stamp_ns);
    std::optional<rt::Nanoseconds>& above = above_ns[row.laser ? 1 : 0];
    if (above && at.stamp_ns < *above) judge.time_backwards(row.place, *above - at.stamp_ns);
    above = at.stamp_ns;
    // The laser's rows repeat the odometry; they tell it only where no other row does.
    if (row.laser != has_odometry)
      odometry.add(receipt_ns, at.stamp_ns, {at.x_m, at.y_m, 0.0},
                   rt::from_yaw_pitch_roll(rt::wrap_angle(at.heading_rad), 0.0, 0.0));
    if (!row.laser) continue;
    judge.returns(at.returns);
    rt::ScanHeader header;
    header.stamp_ns = at.stamp_ns;
    builder.add(receipt_ns, header, std::move(row.content.points));
  }
}

}  // namespace

void import_carmen(RowJudge& judge, LogBuilder& builder) {
  const std::string path = find_log(judge.options().path);
  check_kind(path);
  CarmenReader reader(judge.options().max_range_m);
  std::vector<Row> rows = read_rows(path, reader, judge);
  drop_wild(rows, judge);
  add_rows(rows, judge, builder);
  if (reader.laser_offset_m() != 0.0)
    judge.warn(path + ": its laser sits " + firmware::format_fixed(reader.laser_offset_m(), 3) +
               " m ahead of the robot's origin: say so in the scene ([lidar])");
  judge.finish(true);
}

}  // namespace sortie::toolchain
