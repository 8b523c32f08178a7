// SPDX-License-Identifier: BSD-3-Clause
// What the tests of the depth camera share: a camera without errors, places to look at, and pixels.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "hil/depth_camera.hpp"
#include "tests/hil/oracle.hpp"
#include "tests/hil/sensor_bench.hpp"

namespace sortie::hil {

/// Without any error, gap or bare face.
inline DepthCameraConfig perfect_camera() {
  DepthCameraConfig config;
  config.noise.sigma_share = config.noise.loss = 0.0;
  config.texture = 1.0;
  config.most_gap_m = 1000.0;
  config.clumps = 0.0;
  config.max_range_m = 100.0;
  config.mount_m[0] = config.mount_m[2] = 0.0;
  config.keep_truth = true;
  return config;
}

/// A camera and the frames that it took, one by one, at rest.
struct CameraBench {
  explicit CameraBench(const DepthCameraConfig& c, std::uint64_t seed = 1, const FaultConfig& faults = {})
      : period_ns(rt::kNanosecondsPerSecond / c.rate_hz), camera(c, faults, seed, 0) {}

  void look(const World& world, const Vec3& place_m, const Quat& turn = {}) {
    ++looks;
    camera.advance(RayCaster(world), resting_step(looks * period_ns - kMs, place_m, turn), sink);
  }
  const std::vector<rt::ScanPoint>& points() const { return sink.scans.back().points; }

  rt::Nanoseconds period_ns;
  rt::Nanoseconds looks{};
  DepthCamera camera;
  oracle::KeepingSink sink;
};

inline World camera_world(const std::vector<Solid>& solids) {
  World world;
  for (const Solid& solid : solids) REQUIRE(world.add(solid) == Status::ok);
  REQUIRE(world.finalize() == Status::ok);
  return world;
}

inline World camera_wall(double face_m) {
  return camera_world({make_box({face_m + 0.5, 0, 0, 1, 2000, 0, 900})});
}

inline Vec3 point_of(const rt::ScanPoint& p) {
  return {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)};
}

/// Column and row of a point of the usual picture.
inline std::pair<int, int> pixel_of(const Vec3& p, const DepthCameraConfig& c) {
  const double y = p.y / p.x / std::tan(0.5 * c.width_rad), z = p.z / p.x / std::tan(0.5 * c.height_rad);
  return {static_cast<int>(0.5 * c.columns * (1.0 - y)), static_cast<int>(0.5 * c.rows * (1.0 - z))};
}

}  // namespace sortie::hil
