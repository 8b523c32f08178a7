// SPDX-License-Identifier: BSD-3-Clause
// Which frames a vehicle has on its CAN bus, how often, and who sends them: for the bus-load check.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "drivers/can_load.hpp"
#include "drivers/canopen/ugv_drives.hpp"
#include "firmware_like/profile.hpp"

namespace sortie::firmware {

/// Frames of a vehicle. Each device has a queue of its own, and so have we. Devices' rates come from [can].
class CanStreams {
 public:
  /// Reads how late our own frames may be.
  explicit CanStreams(Profile& profile);

  /// Frames of ours, one after the other from `first_id`.
  void ours(const char* name, std::uint32_t first_id, std::uint32_t count, std::uint8_t size,
            rt::Nanoseconds period_ns);
  /// Frames of one device, from `first_id`, at the rate of the key `can.NAME_hz`.
  void device(const char* name, std::uint32_t first_id, std::uint32_t count, std::uint8_t size,
              double rate_hz, const char* meaning);
  /// Everything that runs between us and the CANopen drives once they are set up. Setting up is not in it:
  /// nothing turns meanwhile, and its frames are less urgent than all others but heartbeats.
  void canopen(const drivers::canopen::UgvDrivesConfig& config);

  /// Of a group that the builder has made.
  rt::Nanoseconds period_of_group(const std::string& name) const;

  std::vector<drivers::CanStream> take() { return std::move(streams_); }

 private:
  drivers::CanStream& add(const std::string& name, std::uint32_t id, std::uint8_t size,
                          rt::Nanoseconds period_ns, int queue);

  Profile& profile_;
  rt::Nanoseconds jitter_ns_{};
  int queues_{1};  // 0: ours
  std::vector<drivers::CanStream> streams_;
};

}  // namespace sortie::firmware
