// SPDX-License-Identifier: BSD-3-Clause
// Where the ground carries, from heights and from what is not known of them: cells for the planner of ways.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/elevation/elevation_view.hpp"
#include "planner/ground_path/ground_map.hpp"
#include "planner/ground_path/stand_prices.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/keys.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {

/// By which rules heights become ground that carries.
struct GroundRules {
  double most_step_m{0.08};  ///< between a cell and the one beside it, and within one: higher ones are walls
  double most_tilt_rad{0.35};  ///< of the ground under the robot, along and across
  double trusted_m{0.0};       ///< around the place where a goal is told
  std::uint32_t rows{16};      ///< of the window that each job reads again, beside all that is near

  SORTIE_KEYS(c, key) {
    key("most_step_m", c.most_step_m,
        {0.01, 1, "m", "between cells of ground beside each other; what is higher is a wall or a drop"});
    key("most_tilt_deg", c.most_tilt_rad, {1, 60, rt::kDegInRad, "of the ground under the robot"});
    key("trusted_m", c.trusted_m,
        {0, 5, "m", "around the place where the robot is told a goal: ground there that nobody saw carries"});
    key("rows", c.rows, {1, 512, "", "of the window that each job reads again, beside all that is near"});
  }
};

/// Where the robot is, for the terrain: its place, and which way its nose looks along the ground.
struct GroundStance {
  rt::Vector3 p_m;
  double cos_yaw{1.0};
  double sin_yaw{};
  double rise_x{};  ///< of the ground under it, per metre along the world's x and y
  double rise_y{};
};

/// Cells of a lattice over a window that moves by leaps. Two sets: the newest, which every job reads again in
/// part, and the planner's, which changes when it takes the newest. A cell carries where
/// - heights were measured in it, and within it they differ by no more than a step;
/// - no known ground beside it lies lower by more than a step: such a cell is the edge of a drop;
/// - or nobody saw it, but the gap in which it lies is no wider than two cells, along x, along y and along
/// both
///   diagonals, and all sides are of one height: no track falls into such a hole;
/// - or the robot stands on it, or somebody vouched for it (GroundRules::trusted_m).
/// What rays passed over, lower by more than a step than the ground beside it, makes that the edge of a hole,
/// though nobody saw its floor. 30 bytes a cell beside the planner's map, no heap.
class GroundTerrain {
 public:
  /// Takes its memory from `arena`. `elevation_cell_mm` divides the lattice's cell.
  GroundTerrain(const GroundPathConfig& lattice, const GroundRules& rules, std::int32_t elevation_cell_mm,
                rt::Arena& arena);
  bool usable() const { return usable_; }

  /// Moves the window where the robot has left its middle. True: it did, and all cells are unknown until they
  /// are read. Cost: that of clearing it, once in some metres.
  bool follow(const rt::Vector3& p_m);
  /// Reads cells again: all that are near the robot, `rows` of the others. `all`: every cell.
  void read(const mapping::ElevationView& view, const GroundStance& stance, bool all);
  /// Somebody told a goal here: what lies around is trusted.
  void trust(const rt::Vector3& p_m) { trusted_ = {true, p_m}; }
  /// Nobody will see this cell: it does not carry. Up to kMostHopeless, until forgive().
  void give_up(std::int64_t x, std::int64_t y);
  void forgive() { hopeless_count_ = 0; }

  /// The planner's cells become the newest. Small changes of what was known stay out, so that its prices
  /// live on. Cost: a look at each cell.
  void hand_over();
  GroundMap& map() { return map_; }
  /// The planner forgets all it knew of the map's changes.
  void forget_changes() {
    std::int32_t x = 0;
    std::int32_t y = 0;
    while (map_.take_changed(x, y)) {
    }
  }
  const GroundMap& map() const { return map_; }
  /// What standing somewhere costs, by the planner's cells.
  PostureSource prices() const { return {&GroundTerrain::price, this, 2, nullptr}; }

  /// The newest of a cell of the window.
  const GroundCell& cell(std::int32_t x, std::int32_t y) const { return newest_[map_.index(x, y)]; }

  /// World number of a lattice cell; of the window's first one; and its middle, m.
  std::int64_t cell_of(double world_m) const;
  std::int64_t low_x() const { return low_[0]; }
  std::int64_t low_y() const { return low_[1]; }
  double middle_m(std::int64_t cell) const {
    return (static_cast<double>(cell) + 0.5) * 1e-3 * lattice_.cell_mm;
  }
  bool is_inside(std::int64_t x, std::int64_t y) const {
    return x >= low_[0] && y >= low_[1] && x < low_[0] + lattice_.nx && y < low_[1] + lattice_.ny;
  }
  /// Height of the window's zero, m: the cells' heights count from it.
  double level_m() const { return level_m_; }
  std::int32_t step_mm() const { return step_mm_; }

  void archive(rt::Archive& archive);

 private:
  static constexpr std::uint32_t kMostHopeless = 256;
  static constexpr std::int32_t kMostGap = 2;  ///< cells of a hole that no track falls into
  static constexpr std::uint8_t kRoughClasses = 4;
  struct Surface {  ///< as the elevation has it
    std::int16_t low_mm{};
    std::int16_t high_mm{};
    std::uint8_t known{};
  };
  struct Column {
    Surface surface[2];
    std::int16_t bound_mm{INT16_MAX};  ///< rays passed at this height; INT16_MAX: none did
  };
  struct Trusted {
    bool is_set{};
    rt::Vector3 p_m;
    SORTIE_FIELDS(is_set, p_m)
  };
  struct Place {
    std::int64_t x{};
    std::int64_t y{};
    SORTIE_FIELDS(x, y)
  };

  static std::uint8_t price(const void* self, const GroundPose& pose);
  void read_columns(const mapping::ElevationView& view, double asker_m, std::int32_t x0, std::int32_t y0,
                    std::int32_t x1, std::int32_t y1);
  void judge(const GroundStance& stance, std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1);
  GroundCell judge_cell(std::int32_t x, std::int32_t y, std::uint8_t& rough) const;
  bool fill_gap(std::int32_t x, std::int32_t y, GroundCell& cell) const;
  bool is_under(const GroundStance& stance, std::int32_t x, std::int32_t y, double margin_m,
                std::int16_t& height_mm) const;
  bool is_hole(const Column& column, std::int32_t ground_mm) const {
    return column.bound_mm != INT16_MAX && ground_mm - column.bound_mm > step_mm_;
  }
  bool is_trusted(std::int32_t x, std::int32_t y) const;
  bool is_hopeless(std::int64_t x, std::int64_t y) const;
  std::int16_t to_mm(double world_m) const;

  GroundPathConfig lattice_;
  GroundRules rules_;
  std::int32_t per_cell_{};  ///< cells of the elevation along an edge of ours
  std::int32_t step_mm_{};
  bool usable_{};
  std::span<Column> columns_;
  std::span<GroundCell> newest_;
  std::span<std::uint8_t> rough_;      ///< of the newest, worst of both surfaces
  std::span<std::uint8_t> map_rough_;  ///< of the planner's
  std::span<GroundCell> map_cells_;
  std::span<std::uint64_t> map_tiles_;
  GroundMap map_;
  bool has_window_{};
  std::int64_t low_[2]{};
  double level_m_{};
  std::int32_t next_row_{};
  Trusted trusted_;
  Place hopeless_[kMostHopeless];
  std::uint32_t hopeless_count_{};
};

}  // namespace sortie::planner
