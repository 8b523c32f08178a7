// SPDX-License-Identifier: BSD-3-Clause
// The height of the ground around the robot, with what is not known of it: a window that rolls with it.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/elevation/elevation_cell.hpp"
#include "mapping/elevation/elevation_view.hpp"
#include "mapping/grid/sensor_pose.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Settings of the map.
struct ElevationConfig {
  std::int32_t size{256};       ///< cells along x and y: 16 .. 2048, a power of two
  std::int32_t cell_mm{50};     ///< edge of a cell: 10 .. 1000 mm
  double min_range_m{0.3};      ///< nearer returns are refused
  double max_range_m{40.0};     ///< farther returns are refused
  double noise_m{0.01};         ///< standard deviation of a return's height, at the sensor
  double noise_per_m{0.002};    ///< and what it grows by with the range: pointing and attitude
  double least_sigma_m{0.003};  ///< no height gets surer: what a surface forgets by
  double felt_sigma_m{0.01};    ///< of a height that was felt
  double join_m{0.03};          ///< returns this close to a surface belong to it
  double most_join_m{0.5};      ///< the same where a height is hardly known any more
  std::uint32_t ray_stride{1};  ///< every so many returns a ray is followed over the cells; 0: none
  double ray_short_m{0.1};      ///< a ray ends so far before its return, along the ground
  double bound_reach_m{1.5};    ///< rays bound cells down to this far below the sensor

  SORTIE_KEYS(c, key) {
    key("cells", c.size, {16, 2048, "", "of the window along x and y, a power of two"});
    key("cell_mm", c.cell_mm, {10, 1000, "mm", "edge of a cell"});
    key("min_range_m", c.min_range_m, {0, 100, "m", "nearer returns are left out"});
    key("max_range_m", c.max_range_m, {0.5, 1000, "m", "farther returns are left out"});
    key("noise_m", c.noise_m, {0.001, 1, "m", "standard deviation of a return's height"});
    key("noise_per_m", c.noise_per_m, {0, 0.1, "", "that much more for each metre of range"});
    key("ray_stride", c.ray_stride, {0, 1000, "", "every so many returns a ray is followed; 0: none"});
  }
};

/// What became of returns, and where the window is.
/// returns = used + outside + not_finite + too_near + too_far.
struct ElevationOutput {
  rt::Nanoseconds stamp_ns{};
  std::uint64_t returns{};
  std::uint64_t used{};
  std::uint64_t outside{};     ///< beyond the window, or above or below all heights; their rays count
  std::uint64_t not_finite{};  ///< or from a pose that was none
  std::uint64_t too_near{};
  std::uint64_t too_far{};
  std::uint64_t lost{};     ///< scans and felt heights refused: the window is not where the robot is
  std::uint64_t joined{};   ///< returns that joined a surface
  std::uint64_t merged{};   ///< surfaces that became one
  std::uint64_t felt{};     ///< heights that the robot felt
  std::uint64_t passed{};   ///< cells that rays passed
  std::uint64_t lowered{};  ///< of them, those whose bound it lowered
  std::uint64_t known{};    ///< cells of the window with a surface
  std::uint64_t rolls{};
  std::uint64_t changes{};  ///< chain over every height and bound that was taken: where, which, how sure
  std::int64_t low_x{};     ///< world number of the window's first cell
  std::int64_t low_y{};
  std::int64_t level_m{};  ///< heights count from here
  SORTIE_FIELDS(stamp_ns, returns, used, outside, not_finite, too_near, too_far, lost, joined, merged, felt,
                passed, lowered, known, rolls, changes, low_x, low_y, level_m)
};

/// A window of cells with up to four surfaces each, and beside them the least height at which rays passed
/// over each cell. All state is whole numbers, relative to the window and to a level of whole metres: the
/// same bits 10 km out as at home. 38 bytes a cell (2.4 MiB at the usual size), no heap.
/// A bound is as true as the pose of its ray; what has been measured is not taken back by rays.
class ElevationMap {
 public:
  /// Takes its memory from `arena`. The map takes nothing (usable() is false) when a setting is out of range
  /// or there is no room.
  ElevationMap(const ElevationConfig& config, rt::Arena& arena);
  bool usable() const { return usable_; }
  /// Bytes of memory that a config asks for.
  static std::uint64_t memory_bytes(const ElevationConfig& config);

  /// Brings the middle of the window to the cell of a place (world, m); what comes in is unknown. The first
  /// one also sets the level that heights count from. Cost: the cells that come in. Status: not_finite;
  /// out_of_range (2^28 cells, or kHeightRange_m from the level): nothing moves.
  Status centre_on(const rt::Vector3& p_world_m);

  /// Adds variance [m^2] to all that is known: what motion since the last call cost, or how far a correction
  /// of the pose may have moved it, 50 at most. Nothing shifts. Cost: none, each cell takes it when it is
  /// asked; all cells do once in 25 m^2.
  Status add_variance(double variance_m2);

  /// The returns of a straightened scan from one pose, without those on the robot. Cost: the returns and the
  /// cells that their rays pass, at most `2 * size` a ray. Status: not_finite (pose); malformed (no points);
  /// time_backwards; out_of_range (the sensor is outside the window). Bad returns are counted one by one.
  Status update(const rt::PointScan& scan, const SensorPose& pose);

  /// Places (world, m) where the robot stands on the ground. Status: not_finite, out_of_range if any was
  /// refused; the others count.
  Status feel(std::span<const rt::Vector3> places_m);

  /// The window, as readers share it.
  ElevationView view() const;
  const ElevationOutput& output() const { return output_; }
  const ElevationConfig& config() const { return config_; }
  /// Forgets everything but where the window is.
  void clear();

  /// The whole window to bytes and back, into a map of the same configuration. O(cells).
  void archive(rt::Archive& archive);

 private:
  struct Sensor;  // where it is, in units

  void clear_cell(std::uint32_t index);
  void roll(std::int64_t low_x, std::int64_t low_y);
  bool place(const rt::Vector3& p_world_m, Sensor& sensor) const;
  std::uint32_t index_of(const std::int32_t (&along)[2]) const;
  void take_return(const Sensor& sensor, const rt::Vector3& way_m);
  void take(std::uint32_t index, std::int32_t height, std::uint16_t weight, std::uint8_t flags);
  void follow_ray(const Sensor& sensor, const std::int32_t (&way)[2], const rt::Vector3& way_m);

  ElevationConfig config_;
  std::span<ElevationCell> cells_;
  std::span<std::int32_t> bounds_;
  std::span<CellEvidence> evidence_;
  ElevationOutput output_;
  SurfaceRule rule_;
  std::uint32_t variance_{};  ///< sum of what was added, kVarianceParts
  std::uint32_t all_aged_{};  ///< that sum when no cell was behind it: none is by half of all numbers
  double variance_rest_{};    ///< of it, what is less than one part
  std::int32_t cell_units_{};
  std::int32_t bound_reach_{};  ///< height units
  std::uint32_t ray_phase_{};
  bool centred_{};
  bool usable_{};
};

}  // namespace sortie::mapping
