// SPDX-License-Identifier: BSD-3-Clause
// Answers a pilot's questions for ways over a map: one of boxes, some of which are noticed only later, or one
// that a lidar fills; in small slices of work.
#pragma once

#include <span>

#include "mapping/occupancy_view.hpp"
#include "planner/uav_path/uav_path.hpp"
#include "planner/uav_way.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

/// Something to keep off: an upright box, known from a moment on.
struct KnownBox {
  rt::Vector3 lowest_m;
  rt::Vector3 highest_m;
  rt::Nanoseconds from_ns{};  ///< since the first update; 0: from the start
};

/// How cells of an occupancy map become voxels. Between the two limits a voxel stays what it was, so that a
/// wall's noise does not make ways come and go.
struct SensedCells {
  std::int32_t low[3]{};  ///< number of the flight map's first voxel in the world, as cells are numbered
  int free_code{};        ///< log-odds of at most this: free
  int blocked_code{};     ///< above this: blocked
};

/// What a guide over a sensed map did.
struct GuideCounts {
  std::uint64_t voxels_changed{};  ///< voxels that became free or blocked
  std::uint64_t hoped{};           ///< questions with no way through what is known to be free
  std::uint64_t begun{};           ///< of those, ways that are flown as far as they are known
  std::uint64_t blocked{};         ///< ways that the map took away
  SORTIE_FIELDS(voxels_changed, hoped, begun, blocked)
};

/// Map, planner and the present question. No heap; memory as given. The answers do not depend on how the
/// slices are dealt out to jobs.
class UavGuide {
 public:
  static constexpr std::uint32_t kSlice = 64;          ///< units of the search in a slice
  static constexpr std::uint32_t kBricksPerSlice = 4;  ///< or bricks of the map

  /// `boxes` outlive the guide, sorted by from_ns; those of 0 are in the map after construction (set-up: some
  /// ms a thousand bricks). `map` and `path` outlive it, and are its own. status() tells whether the map can
  /// be used.
  UavGuide(FlightMap& map, UavPath& path, std::span<const KnownBox> boxes);
  Status status() const { return map_->usable(); }

  /// Set-up, for a map that is sensed: `map` holds what is known, unknown voxels blocked; `hope`, of the same
  /// size, has them free. Where there is no way through the known, the way through the hoped is answered as
  /// far as it is known to be free, and is not whole: who flies it sees more there and asks again.
  void expect(FlightMap& hope, const SensedCells& cells);
  /// Takes over what the occupancy map says by now; what it never measured, or forgot, stays as it was. Not
  /// while a search or a check is under way: the map that it sees stands still. Cost: 3 ns a voxel of the
  /// map, and the change.
  void sense(const mapping::OccupancyView& view);
  const GuideCounts& counts() const { return counts_; }

  /// Takes notice of what is asked and of boxes that have come up by now.
  void look(const WayQuestion* question, rt::Nanoseconds now_ns);
  /// True while there is something to work on: then step() does one slice of it, about 50 us.
  bool works() const { return refreshing_ || searching_ || checking_ != Checking::nothing; }
  void step();

  const UavWay& way() const { return way_; }
  const FlightMap& map() const { return *map_; }

  /// State to bytes and back, into a guide of the same boxes. Reading repeats the slices of a search that was
  /// under way.
  void archive(rt::Archive& archive);

 private:
  // What the exact check of a whole way is for.
  enum class Checking : std::uint8_t { nothing, shown, hoped };
  void check();
  void end_cut(bool is_free);
  void begin();
  void begin_hoped();
  bool wants_hope() const;
  void cut();
  std::uint32_t version() const { return map_->version() + (hope_ != nullptr ? hope_->version() : 0); }
  void put_box(const KnownBox& box);
  void refreshed();
  void note_path(UavWay& way) const;

  FlightMap* map_;
  UavPath* path_;
  std::span<const KnownBox> boxes_;
  FlightMap* hope_{};  ///< null: the map is given
  SensedCells cells_;
  Checking checking_{Checking::nothing};
  WayWalk walk_;   ///< of that check
  UavWay cut_;     ///< Checking::hoped: what is answered if it is free
  bool hoping_{};  ///< the present search is one through `hope_`
  GuideCounts counts_;
  std::uint32_t known_{};
  bool started_{};
  bool refreshing_{};
  bool searching_{};
  rt::Nanoseconds start_ns_{};
  std::uint32_t begun_version_{};  ///< of the map that is searched
  std::uint32_t slices_{};         ///< of the present search
  std::uint32_t checked_version_{};
  WayQuestion question_;
  UavWay way_;
};

}  // namespace sortie::planner
