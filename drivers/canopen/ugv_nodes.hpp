// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's drives on CANopen: two tracks by velocity, four flippers by position. Commands in,
// samples out, in the units of the rest of the program.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/can_load.hpp"
#include "drivers/canopen/node_line.hpp"
#include "drivers/ugv_drives.hpp"
#include "rt/keys.hpp"

namespace sortie::drivers::canopen {

/// Which nodes these are, and what their increments are worth.
struct UgvNodesConfig {
  std::array<std::uint8_t, 2> track_nodes{1, 2};                          ///< left, right
  std::array<std::uint8_t, rt::kFlippers> flipper_nodes{11, 12, 13, 14};  ///< in the order of rt::Flipper
  bool flippers = true;
  double increments_per_m = 10'000.0;
  double increments_per_rad = 10'000.0;
  double rated_torque_n_m = 100.0;  ///< of a flipper: torques come in per mille of it
  double quick_stop_m_s2 = 4.0;     ///< deceleration of a track's quick stop
  double quick_stop_rad_s2 = 20.0;  ///< of a flipper's
  NodeLineConfig line{};
  DriveGroupConfig group{};
  rt::Nanoseconds heartbeat_timeout_ns = 150 * rt::kNanosecondsPerMillisecond;

  SORTIE_KEYS(c, key) {
    shared_drive_keys(c, c.line.sync_period_ns, c.heartbeat_timeout_ns, key);
    key("node_master", c.line.node, {1, 127, "", "number of this drive on the bus"});
    key("increments_per_m", c.increments_per_m, {1, 1e8, "1/m", "canopen: of a track's encoder"});
    key("increments_per_rad", c.increments_per_rad, {1, 1e8, "1/rad", "canopen: of a flipper's encoder"});
    key("rated_torque_n_m", c.rated_torque_n_m, {0.001, 1e6, "N m", "canopen: of a flipper, for its torque"});
    key("heartbeat_ms", c.line.heartbeat_ns,
        {1, 10'000, rt::kMsInNs, "canopen: of each drive and of the runtime, whole ms"});
  }
};

/// What these drives and the runtime put on the bus again and again, for can_load(). Set-up only.
std::vector<CanStream> bus_frames(const UgvNodesConfig& config);

/// An increment counter that wraps at 32 bits, as a number that does not.
class IncrementCount {
 public:
  /// The first reading is 0.
  std::int64_t add(std::int32_t reading) noexcept;
  /// The counter may count from elsewhere now: the next reading is where the last one was.
  void rebase() noexcept { begun_ = false; }

 private:
  std::int64_t total_{};
  std::int32_t last_{};
  bool begun_{};
};

/// All drives of the robot. One thread, no heap after construction.
class UgvNodes final : public UgvDrives {
 public:
  /// Throws std::runtime_error where a setting cannot be used.
  explicit UgvNodes(const UgvNodesConfig& config);
  /// A robot of its own in the same state, for tests that try what may come next.
  UgvNodes(const UgvNodes& other);
  UgvNodes& operator=(const UgvNodes&) = delete;

  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept override {
    return line_.take(frame, now_ns);
  }
  void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept override;

  /// What the drives showed at the same SYNC, stamped with it.
  [[nodiscard]] Status read(rt::TrackSample& sample) noexcept override;
  [[nodiscard]] Status read(rt::FlipperSample& sample) noexcept override;

  const NodeLine& line() const noexcept { return line_; }

 private:
  void attach_all();
  bool all_read(std::size_t first, std::size_t count) const noexcept;
  double travel_m(std::size_t track) noexcept;

  UgvNodesConfig config_;
  NodeLine line_;
  std::array<IncrementCount, 2> travel_{};
  std::array<std::uint64_t, 2> set_ups_{};  // of the tracks, at the newest sample
  rt::Nanoseconds tracks_ns_{-1};
  rt::Nanoseconds flippers_ns_{-1};
};

}  // namespace sortie::drivers::canopen
