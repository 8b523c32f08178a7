// SPDX-License-Identifier: BSD-3-Clause
// CARMEN logs: a planar laser and the pose that the wheels have summed up, row by row as the logger got them.
#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/import/carmen_row.hpp"
#include "toolchain/import/data_set.hpp"
#include "toolchain/import/kinds.hpp"
#include "toolchain/import/odometry_steps.hpp"
#include "toolchain/import/rising_stamps.hpp"
#include "toolchain/import/text_file.hpp"

namespace sortie::toolchain {
namespace {

/// A stamp so far off the order of the rows is none.
constexpr rt::Nanoseconds kWild = 60 * rt::kNanosecondsPerSecond;
constexpr std::size_t kNamesShown = 8;

struct LoggedRow {
  CarmenRow content;
  bool laser{};
  std::string place;
  bool in_order{};           ///< its stamp fits into those of its kind
  rt::Nanoseconds off_ns{};  ///< else how far it is ahead of (above 0) or behind them

  bool is_wild() const { return std::abs(off_ns) >= kWild; }
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

std::vector<LoggedRow> read_log_rows(const std::string& path, CarmenReader& reader, RowJudge& judge) {
  TextFile file(path);
  judge.begin(path);
  std::vector<LoggedRow> rows;
  PassedOver others;
  std::string_view line;
  std::string fault;
  CarmenRow row;
  while (file.next(line)) {
    const CarmenLine kind = reader.read(line, row, fault);
    switch (kind) {
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
      case CarmenLine::laser:
        rows.push_back({std::move(row), kind == CarmenLine::laser, file.place(), false, 0});
        break;
    }
  }
  if (!file.tail().empty()) judge.cut_off(file.size() - file.tail().size(), "the last row has no line end");
  if (!others.text().empty()) judge.warn(path + ": rows of kinds that are not used: " + others.text());
  return rows;
}

/// How far the rows of one kind lie off the longest run of them whose stamps never fall: 0 within it, above 0
/// ahead, below 0 behind.
void find_order(std::vector<LoggedRow>& rows, bool laser) {
  std::vector<LoggedRow*> kind;
  std::vector<rt::Nanoseconds> stamps_ns;
  for (LoggedRow& row : rows) {
    if (row.laser != laser) continue;
    kind.push_back(&row);
    stamps_ns.push_back(row.content.stamp_ns);
  }
  const std::vector<bool> rises = longest_rise(stamps_ns);
  std::optional<rt::Nanoseconds> before_ns;
  std::size_t next = 0;
  for (std::size_t i = 0; i < kind.size(); ++i) {
    kind[i]->in_order = rises[i];
    if (rises[i]) before_ns = stamps_ns[i];
    while (next < kind.size() && (next < i || !rises[next])) ++next;
    const rt::Nanoseconds behind_ns = before_ns ? *before_ns - stamps_ns[i] : 0;
    const rt::Nanoseconds ahead_ns = next < kind.size() ? stamps_ns[i] - stamps_ns[next] : 0;
    kind[i]->off_ns = behind_ns > ahead_ns ? -behind_ns : ahead_ns;
  }
}

/// Takes out the rows whose stamp is a minute or more off the order, and tells of those that are less off.
void drop_wild(const std::string& path, std::vector<LoggedRow>& rows, RowJudge& judge) {
  std::uint64_t off = 0;
  find_order(rows, false);
  find_order(rows, true);
  for (const LoggedRow& row : rows) {
    if (row.is_wild()) {
      judge.bad(row.place, "its stamp lies " + firmware::format_seconds(std::abs(row.off_ns)) + " s " +
                               (row.off_ns < 0 ? "behind" : "ahead of") + " the rows around it");
      continue;
    }
    judge.good();
    if (row.in_order) continue;
    judge.out_of_order();
    ++off;
  }
  if (off > 0)
    judge.warn(path + ": " + std::to_string(off) +
               " rows have stamps out of order; what their odometry drove is told with the next row");
  std::erase_if(rows, [](const LoggedRow& row) { return row.is_wild(); });
}

/// Receipts follow the rows in order: what the logger got first comes first.
void add_log_rows(std::vector<LoggedRow>& rows, RowJudge& judge, LogBuilder& builder) {
  const bool has_odometry =
      std::any_of(rows.begin(), rows.end(), [](const LoggedRow& row) { return !row.laser; });
  OdometrySteps odometry(builder);
  rt::Nanoseconds now_ns = 0;
  std::optional<rt::Nanoseconds> above_ns[2];
  for (LoggedRow& row : rows) {
    const CarmenRow& at = row.content;
    if (row.in_order) now_ns = std::max(now_ns, at.stamp_ns);
    std::optional<rt::Nanoseconds>& above = above_ns[row.laser ? 1 : 0];
    if (above && at.stamp_ns < *above) judge.time_backwards(row.place, *above - at.stamp_ns);
    above = at.stamp_ns;
    // The laser's rows repeat the odometry; they tell it only where no other row does.
    if (row.laser != has_odometry) {
      const rt::Vector3 p_m{at.x_m, at.y_m, 0.0};
      const rt::Quaternion q = rt::from_yaw_pitch_roll(rt::wrap_angle(at.heading_rad), 0.0, 0.0);
      if (row.in_order) {
        odometry.add(now_ns, at.stamp_ns, p_m, q);
      } else {
        odometry.pass(p_m, q);
      }
    }
    if (!row.laser) continue;
    judge.returns(at.returns);
    rt::ScanHeader header;
    header.stamp_ns = at.stamp_ns;
    builder.add(std::max(now_ns, at.stamp_ns), header, std::move(row.content.points));
  }
}

}  // namespace

void import_carmen(RowJudge& judge, LogBuilder& builder) {
  const std::string path = find_log(judge.options().path);
  check_kind(path);
  CarmenReader reader(judge.options().max_range_m);
  std::vector<LoggedRow> rows = read_log_rows(path, reader, judge);
  drop_wild(path, rows, judge);
  add_log_rows(rows, judge, builder);
  if (reader.laser_offset_m() != 0.0)
    judge.warn(path + ": its laser sits " + firmware::format_fixed(reader.laser_offset_m(), 3) +
               " m ahead of the robot's origin: say so in the scene ([lidar])");
  judge.finish(true);
}

}  // namespace sortie::toolchain
