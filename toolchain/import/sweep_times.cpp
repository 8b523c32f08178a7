// SPDX-License-Identifier: BSD-3-Clause
// A spinning lidar takes its columns one after the other, so times rise along each row by even steps.
#include "toolchain/import/sweep_times.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace sortie::toolchain {
namespace {

constexpr std::int64_t kAgeStep_ns = 10 * rt::kNanosecondsPerMicrosecond;
constexpr std::int64_t kLongest_ns = kAgeStep_ns * std::numeric_limits<std::uint16_t>::max();

/// A file that counted backwards from zero holds the bits of a negative number.
std::int64_t time_of(const SweepPoint& point) {
  return static_cast<std::int64_t>(static_cast<std::int32_t>(point.since_first_ns));
}

bool is_none(const SweepPoint& point) {
  return std::isnan(point.x_m) || std::isnan(point.y_m) || std::isnan(point.z_m);
}

/// Columns times the median step from one to the next; 0 where there is none, or none that fits.
std::int64_t turn_of(const std::vector<SweepPoint>& points, std::uint32_t columns) {
  std::vector<std::int64_t> steps;
  steps.reserve(points.size());
  std::size_t last = points.size();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_none(points[i])) continue;  // some drivers give it no time
    if (last < i && last / columns == i / columns)
      steps.push_back((time_of(points[i]) - time_of(points[last])) / static_cast<std::int64_t>(i - last));
    last = i;
  }
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const bool fits = *middle > 0 && *middle <= kLongest_ns / static_cast<std::int64_t>(columns);
  return fits ? *middle * static_cast<std::int64_t>(columns) : 0;
}

using Counter = std::uint64_t ReturnCounts::*;

/// What is wrong with each point of a row; null where nothing is.
void judge_row(std::span<const SweepPoint> row, std::int64_t turn_ns, std::vector<Counter>& faults) {
  faults.assign(row.size(), nullptr);
  std::vector<std::size_t> within;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const std::int64_t t_ns = time_of(row[i]);
    if (is_none(row[i])) {
      faults[i] = &ReturnCounts::no_return;
    } else if (!std::isfinite(row[i].x_m) || !std::isfinite(row[i].y_m) || !std::isfinite(row[i].z_m)) {
      faults[i] = &ReturnCounts::not_finite;
    } else if (t_ns < 0) {
      faults[i] = &ReturnCounts::time_negative;
    } else if (t_ns > turn_ns) {
      faults[i] = &ReturnCounts::time_beyond;
    } else {
      within.push_back(i);
    }
  }
  std::int64_t latest_ns = 0;
  for (std::size_t k = 0; k < within.size(); ++k) {
    const std::int64_t t_ns = time_of(row[within[k]]);
    const std::int64_t next_ns = k + 1 < within.size() ? time_of(row[within[k + 1]]) : t_ns;
    const bool ahead = next_ns < t_ns && next_ns >= latest_ns;
    if (t_ns < latest_ns || ahead) {
      faults[within[k]] = &ReturnCounts::time_unsorted;
    } else {
      latest_ns = t_ns;
    }
  }
}

}  // namespace

TimedScan order_sweep(const std::vector<SweepPoint>& points, std::uint32_t rows, std::uint32_t columns) {
  TimedScan scan;
  if (std::all_of(points.begin(), points.end(), is_none)) {
    scan.fault = "no point of it is a return";
    return scan;
  }
  const std::int64_t turn_ns = turn_of(points, columns);
  if (turn_ns == 0) {
    scan.fault = "the times of its " + std::to_string(columns) +
                 " columns do not rise, or its turn takes longer than 655.35 ms";
    return scan;
  }
  std::vector<const SweepPoint*> kept;
  std::vector<Counter> faults;
  kept.reserve(points.size());
  scan.returns.in = points.size();
  for (std::uint32_t i = 0; i < rows; ++i) {
    const std::span<const SweepPoint> row = std::span(points).subspan(std::size_t{i} * columns, columns);
    judge_row(row, turn_ns, faults);
    for (std::size_t j = 0; j < columns; ++j) {
      if (faults[j] != nullptr) {
        ++(scan.returns.*faults[j]);
      } else {
        kept.push_back(&row[j]);
      }
    }
  }
  scan.returns.used = kept.size();
  if (kept.empty()) {
    scan.fault = "no point of it can be used";
    return scan;
  }
  std::stable_sort(kept.begin(), kept.end(), [](const SweepPoint* a, const SweepPoint* b) {
    return a->since_first_ns < b->since_first_ns;
  });
  scan.newest_ns = time_of(*kept.back());
  scan.points.reserve(kept.size());
  for (const SweepPoint* point : kept) {
    const std::int64_t age_ns = scan.newest_ns - time_of(*point);
    scan.points.push_back({point->x_m, point->y_m, point->z_m, 0,
                           static_cast<std::uint16_t>((age_ns + kAgeStep_ns / 2) / kAgeStep_ns)});
  }
  return scan;
}

}  // namespace sortie::toolchain
