// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's drives on CANopen: two tracks by velocity, four flippers by position. Commands in,
// samples out, in the units of the rest of the program.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/can_load.hpp"
#include "drivers/canopen/master.hpp"
#include "drivers/ugv_motors.hpp"

namespace sortie::drivers::canopen {

/// Which nodes these are, and what their increments are worth.
struct UgvDrivesConfig {
  std::array<std::uint8_t, 2> track_nodes{1, 2};                          ///< left, right
  std::array<std::uint8_t, rt::kFlippers> flipper_nodes{11, 12, 13, 14};  ///< in the order of rt::Flipper
  bool flippers = true;
  double increments_per_m = 10'000.0;
  double increments_per_rad = 10'000.0;
  double rated_torque_n_m = 100.0;  ///< of a flipper: torques come in per mille of it
  MasterConfig master{};
  rt::Nanoseconds heartbeat_ns = 50 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds heartbeat_timeout_ns = 150 * rt::kNanosecondsPerMillisecond;
};

/// What these drives and their master put on the bus again and again, for can_load(). Set-up only.
std::vector<CanStream> bus_frames(const UgvDrivesConfig& config);

/// An increment counter that wraps at 32 bits, as a number that does not.
class IncrementCount {
 public:
  /// The first reading is 0.
  std::int64_t add(std::int32_t reading) noexcept;

 private:
  std::int64_t total_{};
  std::int32_t last_{};
  bool begun_{};
};

/// All drives of the robot. One thread, no heap after construction.
class UgvDrives final : public UgvMotors {
 public:
  /// Throws std::runtime_error where a setting cannot be used.
  explicit UgvDrives(const UgvDrivesConfig& config);

  [[nodiscard]] Status set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept override;
  [[nodiscard]] Status set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept override;
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept override {
    return master_.take(frame, now_ns);
  }
  void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept override { master_.poll(now_ns, bus); }

  /// What the drives showed at the same SYNC, stamped with it.
  [[nodiscard]] Status read(rt::TrackSample& sample) noexcept override;
  [[nodiscard]] Status read(rt::FlipperSample& sample) noexcept override;

  bool running() const noexcept override { return master_.running(); }
  StopReason stop_reason() const noexcept override { return master_.stop_reason(); }
  Master& master() noexcept { return master_; }
  const Master& master() const noexcept { return master_; }

 private:
  bool all_read(std::size_t first, std::size_t count) const noexcept;
  void pass_on(rt::Nanoseconds now_ns) noexcept;

  UgvDrivesConfig config_;
  Master master_;
  std::array<std::int32_t, kMaxDrives> targets_{};
  std::array<IncrementCount, 2> travel_{};
  rt::Nanoseconds tracks_ns_{-1};
  rt::Nanoseconds flippers_ns_{-1};
  bool drive_on_{};
  bool flippers_on_{};
};

}  // namespace sortie::drivers::canopen
