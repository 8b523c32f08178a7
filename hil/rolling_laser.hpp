// SPDX-License-Identifier: BSD-3-Clause
// A 2-D laser scanner on a mount that rolls about the forward axis: the lidar of the tracked robot.
#pragma once

#include "hil/scan_writer.hpp"

namespace sortie::hil {

/// The device and how it is mounted. The mount's base frame: x forward along the rolling axis, y left, z up.
/// At roll 0 the mirror scans the base's x-y plane, from the right to the left.
struct RollingLaserConfig {
  std::uint32_t line_hz{50};                      ///< turns of the mirror a second, 1..200; 0: no laser
  std::uint32_t beams{541};                       ///< of a line, 2..4096
  double fov_rad{4.71238898038468986};            ///< from the first beam to the last, about x (270 deg)
  std::uint32_t lines_per_scan{5};                ///< handed over together
  rt::Nanoseconds roll_period_ns{3'600'000'000};  ///< of one turn of the mount, 0.1..100 s
  std::uint32_t encoder_ticks{4096};  ///< a turn; what is between two ticks the device does not know
  double min_range_m{0.3};
  double max_range_m{20.0};
  RangeNoiseConfig noise{};
  bool keep_truth{};                   ///< 48 bytes a ray, for tests and judges
  double mount_m[3]{0.05, 0.0, 0.45};  ///< place of the base on the body
  double mount_ypr_rad[3]{0, 0, 0};    ///< yaw, pitch, roll of the base on the body
};

/// Angle of the mount: what is, and what the encoder says.
struct RollAngle {
  double true_rad{};      ///< 0..2 pi
  std::uint32_t ticks{};  ///< below encoder_ticks
  double measured_rad{};  ///< the middle of that tick
};

/// The laser. Every beam has its own time, pose and angle of the mount; its point is given in the base frame,
/// turned by what the encoder said when the beam was fired: that is all a driver knows. A scan is
/// `lines_per_scan` lines, stamped with the end of the last. The noise of a scan depends on its number only.
class RollingLaser : public ScanSensor {
 public:
  /// The first line begins at `start_ns`. Throws std::runtime_error naming the setting that is not usable.
  RollingLaser(const RollingLaserConfig& config, const FaultConfig& faults, std::uint64_t seed,
               rt::Nanoseconds start_ns);

  /// As LidarModel::advance(), beam by beam. Cost: 0.4 us a ray, with a shell 0.6.
  void advance(const RayCaster& caster, const SensorStep& step, drivers::ScanSink& sink);

  /// The mount at a time of the plant, which is not before its start.
  RollAngle roll_at(rt::Nanoseconds stamp_ns) const;
  /// Time of a beam: beams of line `line` (from the start on) follow each other evenly in the part of the
  /// mirror's turn that looks out.
  rt::Nanoseconds beam_ns(std::uint64_t line, std::uint32_t beam) const;
  /// Direction of a beam in the base frame at an angle of the mount.
  Vec3 direction(std::uint32_t beam, double roll_rad) const;

 private:
  rt::Nanoseconds line_ns(std::uint64_t line) const;
  void begin_scan(drivers::ScanSink& sink);
  void fire(const RayCaster& caster, const SensorStep& step, rt::Nanoseconds at);

  RollingLaserConfig config_;
  std::uint64_t scan_{};
  std::uint64_t line_{};
  std::uint32_t beam_{};
  bool scanning_{};
  Fault fault_{};
};

}  // namespace sortie::hil
