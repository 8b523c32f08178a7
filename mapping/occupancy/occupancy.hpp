// SPDX-License-Identifier: BSD-3-Clause
// Which cells around the robot are occupied, in one byte each: a window that rolls with the robot.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/sensor_pose.hpp"
#include "mapping/occupancy/occupancy_view.hpp"
#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Settings of the map.
struct OccupancyConfig {
  double voxel_size_m{0.2};
  std::int32_t size[3]{320, 320, 32};   ///< cells of the window along x, y, z
  double anchor[3]{0.34375, 0.5, 0.5};  ///< where in the window its centre point lies, shares of its size
  std::int32_t roll_cells{16};          ///< the window moves by multiples of this, as late as it can
  double prior{1.0 / 12.0};             ///< probability that an unknown cell is occupied
  double hit{0.88};                     ///< what a return says about its cell (2 nats)
  double miss{0.27};                    ///< what a passing ray says about a cell (-1 nat)
  double min_range_m{0.5};              ///< nearer returns are refused
  double max_range_m{48.0};             ///< farther returns free the cells up to here
};

/// The same as it is written: the window in metres, whatever the size of a cell.
struct WrittenOccupancy {
  OccupancyConfig map;  ///< but for `size`
  double window_m[3]{64, 64, 6.4};

  SORTIE_KEYS(c, key) {
    key("voxel_m", c.map.voxel_size_m, {0.02, 2, "m", "edge of a cell"});
    constexpr const char* kWindow = "size of the window that moves with the robot";
    key("window_x_m", c.window_m[0], {0.1, 1000, "m", kWindow});
    key("window_y_m", c.window_m[1], {0.1, 1000, "m", kWindow});
    key("window_z_m", c.window_m[2], {0.1, 1000, "m", kWindow});
    key("prior", c.map.prior, {0.001, 0.999, "", "that an unknown cell is occupied"});
    key("hit", c.map.hit, {0.001, 0.999, "", "what a return says about its cell"});
    key("miss", c.map.miss, {0.001, 0.999, "", "what a passing ray says about a cell"});
    key("min_range_m", c.map.min_range_m, {0, 100, "m", "nearer returns are refused"});
    key("max_range_m", c.map.max_range_m, {0.1, 1000, "m", "farther returns only free what is nearer"});
  }
};

/// What became of rays, and where the window is. rays = used + outside + not_finite + too_near.
struct OccupancyOutput {
  std::uint64_t rays{};
  std::uint64_t used{};
  std::uint64_t outside{};     ///< began outside the window
  std::uint64_t not_finite{};  ///< or from a pose that was none
  std::uint64_t too_near{};
  std::uint64_t misses{};   ///< cells that rays passed
  std::uint64_t hits{};     ///< cells with a return
  std::uint64_t known{};    ///< cells of the window with a measurement
  std::uint64_t changes{};  ///< chain over every measurement: cell of the window, and what it holds since
  std::uint64_t rolls{};
  std::int32_t low_x{};  ///< world number of the window's first cell
  std::int32_t low_y{};
  std::int32_t low_z{};
  SORTIE_FIELDS(rays, used, outside, not_finite, too_near, misses, hits, known, changes, rolls, low_x, low_y,
                low_z)
};

/// Saturating log-odds in int8, in steps of kLogOddsStep. One byte a cell (3.1 MiB at the usual size), no
/// heap. The window is contiguous memory: it rolls by moving the bytes, so that readers walk plain strides.
class OccupancyMap {
 public:
  /// `cells` holds size[0] * size[1] * size[2] bytes or more. The map takes nothing (usable() is false) when
  /// a setting is out of its range: sizes 1..4096 with at most 2^24 cells in all, probabilities within (0,
  /// 1).
  OccupancyMap(const OccupancyConfig& config, std::span<std::int8_t> cells);
  bool usable() const { return usable_; }
  /// Bytes of memory that a config asks for.
  static std::uint64_t memory_bytes(const OccupancyConfig& config);

  /// Brings the window to a place (world, m), in steps of roll_cells; cells that come in are unknown. Cost:
  /// one pass over the map when it moves, nothing otherwise. Status: not_finite; out_of_range beyond 2^28
  /// cells.
  Status centre_on(const rt::Vector3& p_world_m);

  /// One ray from `from` to `to` (world, m): the cells between lose, the last one gains where `hit`. A return
  /// beyond max_range frees what is nearer; one outside the window frees the cells up to its edge. Cost: the
  /// cells passed. Status: not_finite; out_of_range (begins outside, or too near).
  Status update_ray(const rt::Vector3& from, const rt::Vector3& to, bool hit);
  /// Every `stride`-th return of a scan, in their order. Status: not_finite (pose); malformed (no points);
  /// out_of_range (stride 0). Bad returns are counted one by one.
  Status update(const rt::PointScan& scan, const SensorPose& pose, std::uint32_t stride = 1);

  /// The window, as readers share it. It holds until the map rolls.
  OccupancyView view() const;
  const OccupancyOutput& output() const { return output_; }
  const OccupancyConfig& config() const { return config_; }
  /// Sets a cell (window coordinates): for maps that come from elsewhere. The value is clamped.
  void set(std::int32_t x, std::int32_t y, std::int32_t z, int code);
  /// Forgets everything.
  void clear();

  /// Steps for a probability, clamped to the limit; NaN gives 0.
  static int code_of(double probability);

  /// The whole window to bytes and back, into a map of the same configuration. O(cells).
  void archive(rt::Archive& archive);

 private:
  void add(std::uint32_t index, int steps, std::uint64_t& changes);
  void roll(const std::int32_t (&by)[3]);
  /// Cells of the window below its centre point.
  std::int32_t before_anchor(int axis) const {
    return static_cast<std::int32_t>(config_.anchor[axis] * config_.size[axis]);
  }

  OccupancyConfig config_;
  std::span<std::int8_t> cells_;
  OccupancyOutput output_;
  std::int32_t prior_code_{};
  std::int32_t hit_steps_{};
  std::int32_t miss_steps_{};
  bool usable_{};
};

}  // namespace sortie::mapping
