// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's motors on ODrives: two tracks by velocity, four flippers by position.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/can_load.hpp"
#include "drivers/odrive/axis_group.hpp"
#include "drivers/ugv_motors.hpp"

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
  GroupConfig group{};
};

/// What these axes and their master put on the bus again and again, for can_load(): estimates (and currents
/// of flippers) every 10 ms, heartbeats three in a silence. Set-up only.
std::vector<CanStream> bus_frames(const UgvAxesConfig& config);

/// All axes of the robot. No heap after construction.
class UgvAxes final : public UgvMotors {
 public:
  /// Throws std::runtime_error where a setting cannot be used, such as a number whose identifiers are the
  /// robot's own frames (8, 9, 10).
  explicit UgvAxes(const UgvAxesConfig& config);

  [[nodiscard]] Status set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept override;
  [[nodiscard]] Status set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept override;
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept override {
    return group_.take(frame, now_ns);
  }
  void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept override { group_.poll(now_ns, bus); }

  /// Axes send when they like: what came first is moved on to the stamp of the last, at the speed that the
  /// axis says, by 20 ms at most. Travel begins with 0. An estimate is a float: at 10^5 turns (5 km with the
  /// default) it counts in 1/128 turn.
  [[nodiscard]] Status read(rt::TrackSample& sample) noexcept override;
  [[nodiscard]] Status read(rt::FlipperSample& sample) noexcept override;

  bool running() const noexcept override { return group_.running(); }
  StopReason stop_reason() const noexcept override { return group_.stop_reason(); }
  AxisGroup& group() noexcept { return group_; }
  const AxisGroup& group() const noexcept { return group_; }

 private:
  static constexpr std::size_t kAxes = 2 + rt::kFlippers;
  bool together(std::size_t first, std::size_t count, rt::Nanoseconds& stamp_ns) noexcept;
  double turns_at(std::size_t i, rt::Nanoseconds stamp_ns) const noexcept;
  void pass_on(rt::Nanoseconds now_ns) noexcept;

  UgvAxesConfig config_;
  AxisGroup group_;
  std::array<double, kAxes> targets_{};
  std::array<std::uint64_t, kAxes> used_{};  // readings that went into a sample
  std::array<std::uint64_t, 2> set_ups_{};   // of the tracks, at the newest sample
  std::array<double, 2> origin_{};           // turns where travel is zero
  std::array<double, 2> travel_{};           // newest, turns
  rt::Nanoseconds tracks_ns_{-1};
  rt::Nanoseconds flippers_ns_{-1};
  bool drive_on_{};
  bool flippers_on_{};
  bool flippers_moved_{};  // were on at the command before
};

}  // namespace sortie::drivers::odrive
