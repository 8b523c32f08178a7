// SPDX-License-Identifier: BSD-3-Clause
// A lidar's sweep takes a tenth of a second, and the robot moves meanwhile: each return is put where it was
// seen from at its own time, and what lies on the robot itself is left out.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/pose_history.hpp"
#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/grid/self_filter.hpp"
#include "rt/archive.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"

namespace sortie::mapping {

/// Where the sensor sits and which of its returns count.
struct SweepConfig {
  rt::Vector3 p_body_sensor_m;
  rt::Quaternion q_body_sensor;
  rt::Nanoseconds time_offset_ns{};  ///< added to the sensor's stamps: its clock and delay against the poses'
  rt::Nanoseconds max_ahead_ns{100 * rt::kNanosecondsPerMillisecond};  ///< see PoseHistory::at
  double min_range_m{0.5};
  double max_range_m{30.0};
  SelfFilterConfig robot{};

  SORTIE_KEYS(c, key) {
    key("lidar.time_offset_ms", c.time_offset_ns, {-1000, 1000, rt::kMsInNs, "added to the lidar's stamps"});
    key("max_pose_age_ms", c.max_ahead_ns,
        {0, 1e4, rt::kMsInNs,
         "a return this long after the newest pose is placed where the motion went on to"});
  }
};

/// What became of the returns.
struct SweepCounts : PointCounts {
  std::uint64_t on_robot{};
  std::uint64_t unplaced{};  ///< no pose for the sweep, or none so old for the return
  SORTIE_FIELDS(in, used, not_finite, too_near, too_far, on_robot, unplaced, scan_full)
};

/// A sweep as if it had been taken at one moment.
struct StraightSweep {
  Status status{Status::ok};  ///< why there is no pose: empty, stale, out_of_range (see PoseHistory::at)
  rt::PointScan scan;  ///< sensor frame at the header's stamp, all ages zero; lives until the next call
  RigidPose pose;      ///< of the sensor in the world at that stamp
  SweepCounts counts;  ///< of this sweep alone
};

/// Straightens sweeps with the body's poses and knows the flippers. Memory: that of its points and 18 kB.
/// No heap. Deterministic.
class Sweeps {
 public:
  /// `memory` holds the returns of one sweep and outlives this.
  Sweeps(const SweepConfig& config, std::span<rt::ScanPoint> memory);

  /// Status of the config: ok, or out_of_range (then every sweep is refused with it).
  Status usable() const { return usable_; }

  /// A pose of the body. Status: see PoseHistory::add.
  Status add(const StampedPose& body) { return poses_.add(body); }

  /// Where the flippers are from now on. A sweep sees one position of them: at 0.8 rad/s their tip moves 3 cm
  /// in a tenth of a second, which is the filter's margin. Status: ok; not_finite (refused).
  Status set_flippers(const double (&angle_rad)[rt::kFlippers]);

  /// Puts each return of `sweep` where the sensor was at its own time, `stamp - age`, and expresses it in the
  /// sensor's frame at the stamp. A sweep whose stamp has no pose is refused whole; a return older than the
  /// poses alone. Cost: a slerp for each new age (one a column), 60 ns a return.
  StraightSweep straighten(const rt::PointScan& sweep);

  /// Sums since start.
  const SweepCounts& counts() const { return counts_; }

  /// Other ranges from the next sweep on. `out_of_range` and no change unless 0 <= min < max, both finite.
  Status set_ranges(double min_m, double max_m);

  /// State to bytes and back.
  void archive(rt::Archive& archive);

 private:
  struct Moment;  // where the sensor was at one age, in its frame at the stamp
  Status moment_at(rt::Nanoseconds stamp_ns, const RigidPose& reference, Moment& moment) const;
  void place(const rt::ScanPoint& point, const Moment& moment, StraightSweep& result);

  bool is_on_robot(const rt::Vector3& p_body_m) const {
    return robot_.is_robot(p_body_m) || robot_.is_shadowed(config_.p_body_sensor_m, p_body_m);
  }

  SweepConfig config_;
  Status usable_{Status::ok};
  std::span<rt::ScanPoint> memory_;
  PoseHistory poses_;
  SelfFilter robot_;
  double flipper_rad_[rt::kFlippers]{};
  SweepCounts counts_;
};

}  // namespace sortie::mapping
