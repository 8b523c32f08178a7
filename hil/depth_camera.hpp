// SPDX-License-Identifier: BSD-3-Clause
// A stereo camera that delivers points: a picture of ranges at one instant, with what such a device misses.
#pragma once

#include <array>
#include <cstdint>

#include "hil/scan_writer.hpp"

namespace sortie::hil {

/// The device and how it is mounted.
struct DepthCameraConfig {
  std::uint32_t columns{64};              ///< 2..320, evenly spaced on the image plane
  std::uint32_t rows{46};                 ///< 2..240
  std::uint32_t rate_hz{10};              ///< frames a second, 1..30; 0: no camera
  double width_rad{1.2217304763960306};   ///< between the picture's outer edges, 0.05..2.7 (70 deg)
  double height_rad{0.8726646259971648};  ///< the same upright (50 deg)
  double min_range_m{0.3};                ///< nearer points are not reported
  double max_range_m{12.0};
  RangeNoiseConfig noise{.sigma_m = 0.0, .sigma_share = 0.01, .loss = 0.01};
  double texture{0.6};     ///< share of faces with texture, 0..1; the others return nothing
  double most_gap_m{0.3};  ///< nothing where neighbours would be farther apart on the surface, 0.001..1000
  double clumps{0.02};     ///< share of points that are mismatches, in clumps, 0..1
  bool keep_truth{};       ///< 48 bytes a pixel, for tests and judges
  double mount_m[3]{0.05, 0.0, 0.45};  ///< place of the sensor on the body
  double mount_ypr_rad[3]{0, 0, 0};    ///< yaw, pitch, roll of the sensor on the body
};

/// What became of pixels whose ray returned.
struct DepthPixelCounters {
  std::uint64_t sparse{};   ///< no point: the surface is too far or too oblique
  std::uint64_t bare{};     ///< no point, of the others: the face has no texture
  std::uint64_t clumped{};  ///< a point at a wrong place
};

/// The camera. Sensor frame: x along the optical axis, y left, z up. All pixels of a frame are of the frame's
/// instant, which is its stamp. Frame n of a second of f is due at (n + 1) / f. Its noise and clumps depend
/// on the seed and its number alone, not on dropped or refused frames.
///
/// Which faces have texture depends on the seed, a solid's place and size, and the side that is seen; the
/// ground has a face per 4 m x 4 m, a recorded place one per 4 m cube and side. It is the same in each frame,
/// whatever comes to the world later.
///
/// Clumps are patches of 5 x 5 pixels at 0.4 to 0.9 of their true ranges, each point scattered by 0.15 m.
///
/// About 6 kB; heap only in the constructor, and only for truth that is kept.
class DepthCamera : public ScanSensor {
 public:
  static constexpr std::uint32_t kMaxColumns = 320;
  static constexpr std::uint32_t kMaxRows = 240;
  static constexpr std::uint32_t kMaxRate_hz = 30;
  static constexpr std::uint32_t kPatch = 5;  ///< pixels along the edge of a clump

  /// Time counts from `start_ns`. Throws std::runtime_error naming the setting if the config is not usable.
  DepthCamera(const DepthCameraConfig& config, const FaultConfig& faults, std::uint64_t seed,
              rt::Nanoseconds start_ns);

  /// Takes the frames due later than the step's begin and not later than its end, with the pose between the
  /// two, and hands them over. A frame whose pose is no pose has no points; its pixels are counted in
  /// ranges().refused. Cost: about 0.3 us a pixel, in the steps that have a frame.
  void advance(const RayCaster& caster, const SensorStep& step, drivers::ScanSink& sink);

  /// What became of those that ranges() counts as returned, by texture, gaps and clumps.
  const DepthPixelCounters& pixels() const { return pixels_; }
  /// Direction of a pixel, of length 1, sensor frame. Column 0 is at the left, row 0 at the top.
  Vec3 direction(std::uint32_t column, std::uint32_t row) const;
  /// Angle between neighbours in the middle of the picture, where it is largest; of columns or rows,
  /// whichever is larger [rad]. The rule of gaps takes it for all pixels.
  double step_rad() const { return step_rad_; }

 private:
  void take_frame(const RayCaster& caster, const SensorStep& step, rt::Nanoseconds at,
                  drivers::ScanSink& sink);
  void take_pixel(const RayCaster& caster, const RayCaster::Aim& aim, std::uint32_t column,
                  std::uint32_t row);
  void begin_clumps();
  void draw_patches();
  bool misplaced(std::uint32_t column, RangeReading& reading);
  bool textured(const RayCaster& caster, const RangeHit& hit, const Vec3& point_m) const;

  DepthCameraConfig config_;
  std::uint64_t frame_{};
  double step_rad_{};
  std::array<double, kMaxColumns> left_{};  ///< of columns, on an image plane at distance 1
  std::array<double, kMaxRows> up_{};
  Random clumps_;
  std::uint32_t shift_columns_{};  ///< by which this frame's patches begin beside the picture
  std::uint32_t shift_rows_{};
  std::array<double, kMaxColumns / kPatch + 2> nearer_{};  ///< of a row of patches; 0: no clump
  DepthPixelCounters pixels_{};
};

}  // namespace sortie::hil
