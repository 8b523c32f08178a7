// SPDX-License-Identifier: BSD-3-Clause
// Answers a pilot's questions for ways over a map of boxes, some of which are noticed only later; in small
// slices of work.
#pragma once

#include <span>

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

  /// Takes notice of what is asked and of boxes that have come up by now.
  void look(const WayQuestion* question, rt::Nanoseconds now_ns);
  /// True while there is something to work on: then step() does one slice of it, about 50 us.
  bool works() const { return refreshing_ || searching_; }
  void step();

  const UavWay& way() const { return way_; }
  const FlightMap& map() const { return *map_; }

  /// State to bytes and back, into a guide of the same boxes. Reading repeats the slices of a search that was
  /// under way.
  void archive(rt::Archive& archive);

 private:
  void begin();
  void put_box(const KnownBox& box);
  void refreshed();
  void note_path();

  FlightMap* map_;
  UavPath* path_;
  std::span<const KnownBox> boxes_;
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
