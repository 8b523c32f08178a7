// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's solid-state lidar: its task, the commands out and the returns in.
#pragma once

#include "drivers/ssl_port.hpp"
#include "firmware_like/vehicle.hpp"
#include "firmware_like/vehicles/sensor_mount.hpp"
#include "planner/ray_stride.hpp"

namespace sortie::firmware {

/// Where the solid-state lidar sits on the body: [ssl].
SensorMount read_ssl_mount(Profile& profile);

/// What the task puts out.
struct SslOutput {
  rt::Nanoseconds stamp_ns{};  ///< of the newest frame
  std::uint32_t asked{};       ///< number of the newest command
  std::uint32_t answered{};    ///< number of the command that the newest frame answers
  std::uint64_t frames{};      ///< taken
  std::uint64_t rays{};        ///< in them
  std::uint64_t returns{};     ///< of those that met something
  std::uint64_t unasked{};  ///< frames with the number of no command, or of one that was answered: not taken
  std::uint64_t range_sum_mm{};  ///< of the newest frame
  std::uint32_t nearest_mm{};    ///< of the newest frame; 0: nothing came back
  std::uint32_t oldest_10us{};   ///< age of the frame's first ray
  SORTIE_FIELDS(stamp_ns, asked, answered, frames, rays, returns, unasked, range_sum_mm, nearest_mm,
                oldest_10us)
};

/// Group `ssl`, task `ssl`: takes what came back, and asks for the next rays. Rays are strides over the field
/// of view until a scheduler chooses them. newest() is where a map takes the returns from, ray by ray, with
/// their ages.
class UgvSsl {
 public:
  /// Declares group, stream, task and outlet. Throws ProfileError.
  explicit UgvSsl(VehicleBuilder& builder);

  /// I/O thread: commands that are due go to the device and into the log, frames come in.
  void poll(const Devices& devices, rt::Nanoseconds now_ns);

  /// The newest frame that was taken: of the task's group alone.
  const rt::SslReturns& newest() const { return newest_; }

 private:
  void take(const rt::SslReturns& returns, SslOutput& output);

  rt::Stream<rt::SslReturns>* returns_{};
  InputPort<rt::SslReturns>* port_{};
  Outlet<rt::SslCommand>* outlet_{};
  std::uint32_t rays_{};
  planner::RayStride stride_;
  rt::SslReturns newest_;
  std::int64_t commands_sent_{};
  std::uint64_t commands_refused_{};
};

}  // namespace sortie::firmware
