// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's motors on ODrives: two tracks by velocity, four flippers by position.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/can_load.hpp"
#include "drivers/odrive/axis_line.hpp"
#include "drivers/ugv_drives.hpp"
#include "rt/keys.hpp"

namespace sortie::drivers::odrive {

/// Which axes these are, and what their turns are worth.
struct UgvAxesConfig {
  std::array<std::uint8_t, 2> track_nodes{1, 2};                          ///< left, right
  std::array<std::uint8_t, rt::kFlippers> flipper_nodes{11, 12, 13, 14};  ///< in the order of rt::Flipper
  bool flippers = true;
  double turns_per_m = 20.0;
  double turns_per_rad = 16.0;
  double torque_per_a_n_m = 1.0;  ///< of a flipper, at the flipper
  double current_limit_a = 20.0;
  double velocity_limit_turn_s = 40.0;
  rt::Nanoseconds silence_ns = 150 * rt::kNanosecondsPerMillisecond;
  bool prove_watchdog = true;
  rt::Nanoseconds period_ns = 10 * rt::kNanosecondsPerMillisecond;  ///< of a cycle
  DriveGroupConfig group{};

  SORTIE_KEYS(c, key) {
    shared_drive_keys(c, c.period_ns, c.silence_ns, key);
    key("turns_per_m", c.turns_per_m, {1e-3, 1e6, "1/m", "odrive: of a track's motor"});
    key("turns_per_rad", c.turns_per_rad, {1e-3, 1e6, "1/rad", "odrive: of a flipper's motor"});
    key("torque_per_a_n_m", c.torque_per_a_n_m,
        {-1e4, 1e4, "N m/A", "odrive: of a flipper, by the current of its motor"});
    key("velocity_limit_turn_s", c.velocity_limit_turn_s,
        {1e-3, 1e4, "1/s", "odrive: no motor turns faster"});
    key("current_limit_a", c.current_limit_a, {1e-3, 1e4, "A", "odrive: of each motor"});
    key("prove_watchdog", c.prove_watchdog, {"odrive: each axis must stop by itself once before it may run"});
  }
};

/// What these axes and the runtime put on the bus again and again, for can_load(): estimates (and currents
/// of flippers) every 10 ms, heartbeats three in a silence. Set-up only.
std::vector<CanStream> bus_frames(const UgvAxesConfig& config);

/// All axes of the robot. No heap after construction.
class UgvAxes final : public UgvDrives {
 public:
  /// Throws std::runtime_error where a setting cannot be used, such as a number whose identifiers are the
  /// robot's own frames (8, 9, 10).
  explicit UgvAxes(const UgvAxesConfig& config);
  /// A robot of its own in the same state, for tests that try what may come next.
  UgvAxes(const UgvAxes& other);
  UgvAxes& operator=(const UgvAxes&) = delete;

  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept override {
    return line_.take(frame, now_ns);
  }
  void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept override;

  /// Axes send when they like: what came first is moved on to the stamp of the last, at the speed that the
  /// axis says, by 20 ms at most. Travel begins with 0. An estimate is a float: at 10^5 turns (5 km with the
  /// default) it counts in 1/128 turn.
  [[nodiscard]] Status read(rt::TrackSample& sample) noexcept override;
  [[nodiscard]] Status read(rt::FlipperSample& sample) noexcept override;

  const AxisLine& line() const noexcept { return line_; }

 private:
  static constexpr std::size_t kAxes = 2 + rt::kFlippers;
  void attach_all();
  bool together(std::size_t first, std::size_t count, rt::Nanoseconds& stamp_ns) noexcept;
  double turns_at(std::size_t i, rt::Nanoseconds stamp_ns) const noexcept;

  UgvAxesConfig config_;
  AxisLine line_;
  std::array<std::uint64_t, kAxes> used_{};  // readings that went into a sample
  std::array<std::uint64_t, 2> set_ups_{};   // of the tracks, at the newest sample
  std::array<double, 2> origin_{};           // turns where travel is zero
  std::array<double, 2> travel_{};           // newest, turns
  rt::Nanoseconds tracks_ns_{-1};
  rt::Nanoseconds flippers_ns_{-1};
};

}  // namespace sortie::drivers::odrive
