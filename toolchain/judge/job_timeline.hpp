// SPDX-License-Identifier: BSD-3-Clause
// When jobs took long, and what the robot was doing then: the longest job of each group in short spans of
// time, and the odometry's mode.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware_like/runtime/runtime.hpp"

namespace sortie::toolchain {

/// The longest of the values that fell into each of equal spans of time. Where the spans no longer suffice
/// they grow to twice their length: any run fits, in at most kMost of them.
class SpanMaxima {
 public:
  static constexpr std::size_t kMost = 600;
  struct Span {
    double from_s{};
    double to_s{};
    double most{};
    std::uint64_t count{};
  };

  /// Values may come in any order of time from 0 on; a time that is negative or not finite is left out.
  void add(double time_s, double value);
  /// Spans with a value, in order.
  std::vector<Span> spans() const;

 private:
  double length_s_{0.1};
  std::vector<Span> spans_;  // by number; count 0: no value
};

/// One group over time.
struct GroupTimeline {
  std::string name;
  SpanMaxima job_us;  ///< wall time of all tasks of a job
};

/// What the odometry said that it was on, from then on.
struct ModeChange {
  double time_s{};
  std::uint32_t mode{};  ///< of estimators::ObstacleMode
};

/// Follows the jobs of a run. Memory: some kB a group, and 16 bytes a change of mode.
class JobTimeline {
 public:
  /// After each job of any group, one at a time (ReplayOptions::on_job).
  void job(const rt::JobRecord& record, const firmware::Runtime& runtime);

  const std::vector<GroupTimeline>& groups() const { return groups_; }
  const std::vector<ModeChange>& modes() const { return modes_; }
  double end_s() const { return end_s_; }

 private:
  void find(const firmware::Runtime& runtime);

  const firmware::Runtime* runtime_{};
  const rt::TaskBase* odometry_{};
  std::vector<GroupTimeline> groups_;
  std::vector<ModeChange> modes_;
  double end_s_{};
};

}  // namespace sortie::toolchain
