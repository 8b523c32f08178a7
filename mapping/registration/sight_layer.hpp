// SPDX-License-Identifier: BSD-3-Clause
// A cloud as cells with a surface each, and from where each of them was seen: what clouds of different
// sensors are compared by.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/plane_cell.hpp"
#include "mapping/registration/plane_pose.hpp"
#include "mapping/registration/surfel_layer.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// Cells and their memory. The defaults fit a laser's cloud; a camera's, with noise of 1 % of the range,
/// wants cells of 0.6 m, 12 points and 0.12 m.
struct SightConfig {
  double cell_m{0.4};
  std::uint32_t min_points{8};      ///< that make a surface
  double most_thickness_m{0.05};    ///< standard deviation across a surface; a thicker cell is left out,
  double most_flatness{0.25};       ///< and one whose variance across is more than this part of the next one
  std::uint32_t cells{16'384};      ///< room, whether flat or not
  std::uint32_t window_cells{128};  ///< along x and along y, a power of two: a cloud is no wider
  std::uint32_t window_cells_up{32};  ///< along z
  std::uint32_t points{4096};         ///< most of one insert()

  SORTIE_KEYS(c, key) {
    key("limits.cloud_cells", c.cells, {64, 1 << 20, "cells", "room for the cloud, 190 bytes each"});
    key("min_points", c.min_points,
        {1, 10'000, "points", "of a cell that has a surface; more for a camera of more pixels"});
    key("window_cells", c.window_cells,
        {8, 4096, "cells", "most along x and along y, a power of two; 4 bytes for each in it"});
    key("window_cells_up", c.window_cells_up, {8, 4096, "cells", "most along z, a power of two"});
  }
};

/// A flat cell, in the frame of its cloud.
struct SightCell {
  rt::Vector3 mean_m;
  rt::Vector3 normal;  ///< to the side that it was seen from
  rt::Vector3 from_m;  ///< where the sensor was that saw it last
  double sigma_m{};    ///< of the mean, across the surface
};

/// A cell's; its normal still points to the side that was seen.
constexpr SightCell mirrored(const SightCell& cell, const rt::Vector3& axis) {
  return {mirrored(cell.mean_m, axis), mirrored(cell.normal, axis), mirrored(cell.from_m, axis),
          cell.sigma_m};
}

/// A cell as it is kept. 96 bytes in canonical form.
struct SightRecord {
  std::uint64_t key{};  ///< SurfelCell::key()
  SurfelSums sums;
  rt::Vector3 from_m;  ///< where the sensor was that saw it last, in the cloud's frame
  SORTIE_FIELDS(key, sums, from_m)
};

/// Points go in view by view; then prepare() makes the cells. All memory comes from an arena: 190 bytes a
/// cell, 4 an entry of the window, 8 a point. The same cells whatever the order of a view's points.
class SightLayer {
 public:
  SightLayer(const SightConfig& config, rt::Arena& arena);

  /// Points of the cloud's frame that were seen from one place; at most SightConfig::points. full: more;
  /// not_finite: `from_m`; then none of them is taken. Points that are not finite are left out. A look-up a
  /// point, twice.
  Status insert(std::span<const rt::Vector3> points_m, const rt::Vector3& from_m);
  /// Adds cells of another cloud, whose edge is half of this one's; after a clear(), by rising key. Each
  /// takes eight of the other's, from `first` of them on along each axis, -1 or 0: eight grids in all. What
  /// there is no room for is left out. Returns what is added to a place of the other's frame to get to this
  /// one's. A look-up a cell, 0.1 us.
  rt::Vector3 widen(const SightLayer& fine, std::span<const SurfelIndex> some,
                    const std::int32_t (&first)[3]);
  /// Makes cells() of all points so far: a sort and a pass over all cells.
  void prepare() { make_cells(begin_cells()); }
  /// The same in pieces: a sort, and then what it returned, some at a time and in its order; 0.5 us each.
  std::span<const SurfelIndex> begin_cells();
  void make_cells(std::span<const SurfelIndex> some);
  void clear();

  /// Flat cells, by rising key of their places; as of the last prepare().
  std::span<const SightCell> cells() const { return flat_.first(count_); }
  /// The flat cell that a place lies in, or null; after a prepare(), until the next insert(). A look-up.
  const SightCell* at(const rt::Vector3& p_m) const {
    SurfelPlace place;
    if (!layer_.place(p_m.x, p_m.y, p_m.z, place)) return nullptr;
    const SurfelIndex surfel = layer_.find(place.cell);
    if (surfel == kNoSurfel || flat_of_[surfel] >= count_) return nullptr;
    return &flat_[flat_of_[surfel]];
  }
  double cell_m() const { return config_.cell_m; }
  const SightConfig& config() const { return config_; }
  /// Cells with points, flat or not.
  std::size_t size() const { return layer_.size(); }
  const SurfelLayerCounts& counts() const { return layer_.counts(); }

  /// The cells with points, by rising key. A sort; lives until the layer changes.
  std::span<const SurfelIndex> by_key() const { return layer_.by_key(); }
  SightRecord record(SurfelIndex index) const {
    const SurfelRecord surfel = layer_.record(index);
    return {surfel.key, surfel.sums, from_[index]};
  }
  /// Adds a cell that was kept; what it was kept in gives them by rising key, after a clear(). Then cells()
  /// is empty until prepare(). malformed: it cannot be one (fault_of(), or `from_m` is not finite); full: no
  /// room; out_of_range: another one has its place in the window. A look-up.
  Status put(const SightRecord& record);

  /// Gives `take` some cells with points, by_key() all of them, as PlaneGrowing takes them: of all their
  /// points, the normal to the side that they were seen from. Left out: cells beyond the reach of
  /// PlaneCell::at, 2^19 edges. `take` must not change the layer. 1 us a cell.
  template <class F>
  void for_each_plane_cell(std::span<const SurfelIndex> some, F&& take) const {
    PlaneCell cell;
    for (const SurfelIndex index : some) {
      if (plane_cell(index, cell)) take(cell);
    }
  }

  /// State to bytes and back. cells() are not among it: after reading they are none until prepare(). Bytes of
  /// something else leave no cell.
  void archive(rt::Archive& archive);

 private:
  static SurfelLayer make_layer(const SightConfig& config, rt::Arena& arena);
  bool plane_cell(SurfelIndex index, PlaneCell& out) const;

  SightConfig config_;
  SurfelLayer layer_;
  std::span<rt::Vector3> from_;       ///< of each surfel
  std::span<std::uint32_t> flat_of_;  ///< of each surfel: its place in flat_, or count_ and more
  std::span<SightCell> flat_;
  std::span<std::uint64_t> scratch_;
  std::uint32_t count_{};
  std::uint32_t views_{};
};

}  // namespace sortie::mapping
