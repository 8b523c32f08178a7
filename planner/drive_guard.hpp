// SPDX-License-Identifier: BSD-3-Clause
// Why the drive stops, and when it may go on.
#pragma once

#include <cstdint>

#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// Reasons to stand still, as bits of UgvDriveOutput::stop. Any number of them may hold at once.
enum DriveStop : std::uint32_t {
  kStopStarting = 1u,        ///< the wait at the start is not over
  kStopHalt = 2u,            ///< somebody outside said so
  kStopCommandStale = 4u,    ///< who is in control outside has fallen silent
  kStopImuStale = 8u,        ///< the IMU has
  kStopOdometryStale = 16u,  ///< the tracks' encoders have
  kStopPoseLost = 32u,       ///< no pose, an old one, or one that is not finite
  kStopTilted = 64u,         ///< roll or pitch beyond its limit
  kStopStuck = 128u,         ///< the route is not getting any nearer
  kStopEmergency = 256u,     ///< somebody outside has pressed the emergency stop by a request
  kStopNoWay = 512u,         ///< it was told a goal, and there is no way there that is known to carry
};

/// How often each reason has begun, since start.
struct DriveStopCounters {
  std::uint32_t starting{};
  std::uint32_t halt{};
  std::uint32_t command_stale{};
  std::uint32_t imu_stale{};
  std::uint32_t odometry_stale{};
  std::uint32_t pose_lost{};
  std::uint32_t tilted{};
  std::uint32_t stuck{};
  std::uint32_t emergency{};
  std::uint32_t no_way{};
  SORTIE_FIELDS(starting, halt, command_stale, imu_stale, odometry_stale, pose_lost, tilted, stuck, emergency,
                no_way)
};

/// Calls `use(name)` for each reason in `stop`, bits of DriveStop; the names are those of the counters.
template <class Use>
void for_each_drive_stop(std::uint32_t stop, Use use) {
  const DriveStopCounters named;
  std::uint32_t bit = 1;
  DriveStopCounters::fields(named, [&](const char* name, const std::uint32_t&) {
    if ((stop & bit) != 0) use(name);
    bit <<= 1u;
  });
}

/// When a robot is tilted, and how old a pose may be.
struct DriveGuardConfig {
  double max_roll_rad{0.7};
  double max_pitch_rad{0.8};
  double tilt_hysteresis_rad{0.1};  ///< both must be this far below their limits again
  rt::Nanoseconds max_pose_age_ns{300 * rt::kNanosecondsPerMillisecond};
  rt::Nanoseconds resume_ns{200 * rt::kNanosecondsPerMillisecond};  ///< without any reason, at rest

  SORTIE_KEYS(c, key) {
    key("max_pose_age_ms", c.max_pose_age_ns, {1, 1e4, rt::kMsInNs, "with an older pose the robot stops"});
    key("max_roll_deg", c.max_roll_rad, {1, 180, rt::kDegInRad, "tilted further the robot stops"});
    key("max_pitch_deg", c.max_pitch_rad, {1, 90, rt::kDegInRad, "tilted further the robot stops"});
    key("tilt_hysteresis_deg", c.tilt_hysteresis_rad,
        {0, 90, rt::kDegInRad, "it goes on when both are so far below their limits"});
    key("resume_ms", c.resume_ns,
        {0, 1e5, rt::kMsInNs, "after a stop: at rest and without any reason for so long"});
  }
};

/// What the guard judges at one moment.
struct DriveFacts {
  bool starting{};
  bool halted{};
  bool emergency{};
  bool command_stale{};
  bool imu_stale{};
  bool odometry_stale{};
  bool stuck{};
  bool no_way{};
  bool though_tilted{};  ///< who is in control has said that a tilt is no reason
};

/// Keeps the reasons. A stop, once begun, is carried through until the robot is at rest, has been so for
/// resume_ns, and no reason has held in that time: only then clear() is true again. 80 bytes; no heap.
class DriveGuard {
 public:
  explicit DriveGuard(const DriveGuardConfig& config) : config_(config) {}

  /// Judges. While the wait at the start lasts nothing else is judged.
  void update(const DriveFacts& facts, const rt::PoseEstimate& pose, bool at_rest, rt::Nanoseconds now_ns);

  /// True when the robot may move.
  bool clear() const { return !stopping_; }
  /// Reasons that hold now, bits of DriveStop.
  std::uint32_t reasons() const { return reasons_; }
  /// True while roll or pitch is beyond its limit, whether that is a reason or not.
  bool tilted() const { return tilted_; }
  const DriveStopCounters& counters() const { return counters_; }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "drive guard")
        .fixed(config_)
        .state(counters_, reasons_, tilted_, stopping_, quiet_since_ns_);
  }

 private:
  DriveGuardConfig config_;
  DriveStopCounters counters_;
  std::uint32_t reasons_{};
  bool tilted_{};
  bool stopping_{true};
  rt::Nanoseconds quiet_since_ns_{-1};
};

}  // namespace sortie::planner
