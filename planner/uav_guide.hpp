// SPDX-License-Identifier: BSD-3-Clause
// Answers a pilot's questions for ways over a map: one of boxes, some of which are noticed only later, or one
// that a lidar fills; in small slices of work.
#pragma once

#include <span>

#include "mapping/occupancy/occupancy_view.hpp"
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
  std::uint64_t begun{};           ///< of those, with a known way to some place on the hoped one
  std::uint64_t hopeless{};        ///< of those, with no way either if all that is unknown were free
  std::uint64_t backed_off{};      ///< questions from a place too near to something: away from it first
  std::uint64_t blocked{};         ///< ways that the map took away
  SORTIE_FIELDS(voxels_changed, hoped, begun, hopeless, backed_off, blocked)
};

/// Places on a hoped way where what is known to be free ends, the nearest to the goal first.
struct WayAims {
  static constexpr std::uint32_t kMost = 8;
  std::uint32_t count{};
  std::uint32_t next{};
  double p_world_m[kMost][3]{};
  SORTIE_FIELDS(count, next, p_world_m)
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
  /// size, has them free. Where there is no way through the known to the goal, there may be one through the
  /// hoped. Then the answer is a way through the known, which is not whole, to that place on the hoped way
  /// which is nearest to its end: who flies there sees more and asks again. The hoped way itself is not
  /// flown, not even its beginning: a sensor that does not look up or down leaves the voxels over and under
  /// the vehicle unknown, and a way that begins there would end where it begins.
  void expect(FlightMap& hope, const SensedCells& cells);
  /// Takes over what the occupancy map says by now; what it never measured, or forgot, stays as it was. Not
  /// while a search or a check is under way: the map that it sees stands still. Cost: 3 ns a voxel of the
  /// map, and the change.
  void sense(const mapping::OccupancyView& view);
  /// Somebody else has said what is in voxels of the map.
  void changed() { refreshing_ = true; }
  const GuideCounts& counts() const { return counts_; }

  /// Takes notice of what is asked and of boxes that have come up by now.
  void look(const WayQuestion* question, rt::Nanoseconds now_ns);
  /// True while there is something to work on: then step() does one slice of it, about 50 us.
  bool works() const { return refreshing_ || searching_ || checking_; }
  void step();

  const UavWay& way() const { return way_; }
  const FlightMap& map() const { return *map_; }

  /// State to bytes and back, into a guide of the same boxes. Reading repeats the slices of a search that was
  /// under way.
  void archive(rt::Archive& archive);

 private:
  enum class Search : std::uint8_t {
    known,    ///< through the known to the goal
    hoped,    ///< through the unknown to the goal
    aimed,    ///< through the known to a place on the hoped way
    backing,  ///< straight away from something that the start is too near to
  };
  void begin();
  void begin(Search search);
  PathState begin_path();
  void ended();
  bool goes_on(PathState state);
  void begin_backing();
  void back_off();
  void try_next_place();
  void give_up_backing();
  void take_aims();
  bool is_consistent() const;
  const FlightMap& searched() const { return search_ == Search::hoped ? *hope_ : *map_; }
  std::uint32_t version() const { return map_->version() + (hope_ != nullptr ? hope_->version() : 0); }
  void put_box(const KnownBox& box);
  void refreshed();
  void check();
  void note_path();

  FlightMap* map_;
  UavPath* path_;
  std::span<const KnownBox> boxes_;
  FlightMap* hope_{};  ///< null: the map is given
  SensedCells cells_;
  Search search_{Search::known};  ///< the present or the last one
  WayAims aims_;                  ///< backing: [0] is the place that is tried, `next` how many were
  WayWalk walk_;                  ///< of the way that is shown, or to that place
  double share_{1.0};  ///< of the vehicle's size that the way keeps: less than 1 where it backs off
  GuideCounts counts_;
  std::uint32_t known_{};
  bool started_{};
  bool refreshing_{};
  bool searching_{};
  bool checking_{};  ///< the way that is shown, in a map that has changed
  rt::Nanoseconds start_ns_{};
  std::uint32_t begun_version_{};  ///< of the map that is searched
  std::uint32_t slices_{};         ///< of the present search
  std::uint32_t checked_version_{};
  WayQuestion question_;
  UavWay way_;
};

}  // namespace sortie::planner
