// SPDX-License-Identifier: BSD-3-Clause
// Planes of a map, grown over the cells of a grid and kept up to date where cells change.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/plane.hpp"
#include "mapping/registration/plane_cell.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/describe.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Settings of the growing of planes.
struct PlaneGrowingConfig {
  double cell_m{0.4};              ///< edge of a cell
  double most_angle_rad{0.1396};   ///< between the normals of a cell and its plane: 8 degrees
  double most_offset_m{0.05};      ///< of a cell's mean from its plane
  double merge_angle_rad{0.0524};  ///< between planes that are one: 3 degrees,
  double merge_gap_m{1.0};         ///< and their rectangles are no further apart than this
  double most_thickness_m{0.04};   ///< standard deviation of a flat cell along its normal
  double most_flatness{0.1};       ///< of its least variance over its second one
  std::uint32_t min_points{5};     ///< of a cell
  std::uint32_t min_cells{4};      ///< of a plane
  std::uint32_t most_weight{16};   ///< points of a cell that count: near cells must not outvote far ones
  bool signed_normals{false};      ///< normals of cells point to where they were seen from
};

/// A cell as it is kept. 128 bytes.
struct PlaneCellSlot {
  std::int32_t at[3]{};
  float normal[3]{};
  double mean_m[3]{};      ///< in the grid's frame
  PlaneSums sums;          ///< relative to the cell's own centre
  std::uint32_t next{};    ///< of its plane, or of the free slots; counted from 1, 0: none
  std::uint32_t before{};  ///< of its plane
  std::uint16_t region{};  ///< counted from 1; 0: none
  std::uint8_t used : 1 {};
  std::uint8_t flat : 1 {};
  std::uint8_t waiting : 1 {};   ///< in the heap
  std::uint8_t released : 1 {};  ///< once, since it changed
  std::uint8_t grade{};          ///< the flattest are seeds first
};

/// A plane while it grows.
struct PlaneRegion {
  std::int32_t anchor[3]{};  ///< cell that its sums are relative to: its seed
  std::uint32_t first{};     ///< cell
  std::uint32_t cells{};     ///< 0: not in use
  std::uint32_t fitted{};    ///< cells when it was fitted last
  std::uint32_t id{};
  PlaneSums sums;
  rt::Vector3 normal;
  double offset_m{};
  Plane shape;     ///< as of the last time that it was shaped
  bool changed{};  ///< since it was shaped
  bool single{};   ///< compared with all others since it changed
};

/// Memory of a growing: value-initialised arrays. `table`: a power of two, at least twice `cells`.
struct PlaneGrowingMemory {
  std::span<PlaneCellSlot> cells;  ///< at most 2^20
  std::span<std::uint32_t> table;
  std::span<std::uint64_t> heap;   ///< as long as `cells`
  std::span<std::uint32_t> queue;  ///< as long as `cells`
  std::span<PlaneRegion> regions;  ///< at most 65,535; four times the planes that are wanted
};

/// What happened so far.
struct PlaneGrowingCounts {
  std::uint64_t cells_full{};    ///< cells that found no room
  std::uint64_t regions_full{};  ///< seeds that found no room
  std::uint64_t seeds{};
  std::uint64_t merged{};
  std::uint64_t released{};  ///< cells that their plane moved away from
  SORTIE_FIELDS(cells_full, regions_full, seeds, merged, released)
};

/// Region growing: from the flattest cell that has no plane yet to neighbours (26) whose normal and mean fit
/// the plane so far, which is fitted again each time that it has grown by half. Cells that the final plane
/// does not fit are let go. Coplanar regions whose rectangles nearly touch become one. A changed cell leaves
/// its plane, and looks for one among its neighbours' before it is a seed. The order in which cells are given
/// between two runs does not matter: seeds come in the order of their grade and place, sums are whole
/// numbers. Unit of work: a cell looked at with its 26 neighbours, about 0.5 us.
class PlaneGrowing {
 public:
  PlaneGrowing(const PlaneGrowingConfig& config, const PlaneGrowingMemory& memory);

  /// A cell that is new or has changed; with a count of 0 it goes. `not_finite`, `out_of_range` (place, mean
  /// more than one edge off, normal not unit, variances negative or not rising by more than rounding),
  /// `full`: then nothing changes. ~0.2 us.
  Status set_cell(const PlaneCell& cell);

  /// Works on for at most `units`, and takes what it used off. True when there is nothing left to do.
  bool run(std::uint64_t& units);

  /// The planes as they are, largest area first, ties by id; at most kMostPlanes of at least min_cells cells.
  /// Regions that grow right now are left out. Returns how many had no room.
  std::uint32_t planes(PlaneSet& out) const;

  const PlaneGrowingCounts& counts() const { return counts_; }
  std::uint32_t cells() const { return used_; }
  std::uint32_t regions() const;

 private:
  enum class Stage : std::uint8_t { seed, grow, settle, finish, merge, done };

  std::uint32_t find(const std::int32_t (&at)[3]) const;
  std::uint32_t insert(const std::int32_t (&at)[3]);
  void erase(std::uint32_t cell);
  void push(std::uint32_t cell);
  std::uint32_t pop();

  void take_out(std::uint32_t cell);
  void put_in(std::uint32_t cell, std::uint16_t region);
  bool fits(const PlaneRegion& region, const PlaneCellSlot& cell, double& off_m) const;
  static PlaneSums relative(PlaneSums sums, const std::int32_t (&at)[3], const PlaneRegion& region);
  void fit(PlaneRegion& region);
  void shape(PlaneRegion& region);
  std::uint16_t new_region(std::uint32_t seed);
  void dissolve(std::uint16_t region);
  std::uint16_t best_neighbour(const PlaneCellSlot& cell) const;

  void seed();
  void grow();
  void settle(std::uint16_t region);
  void finish();
  void merge();
  bool coplanar(const PlaneRegion& a, const PlaneRegion& b) const;
  void unite(std::uint16_t into, std::uint16_t from);
  std::uint64_t next_cost() const;

  PlaneGrowingConfig config_;
  PlaneGrowingMemory memory_;
  double least_cosine_;
  double merge_cosine_;
  Stage stage_{Stage::done};
  std::uint32_t used_{};
  std::uint32_t free_{1};
  std::uint32_t heap_size_{};
  std::uint32_t queue_begin_{};
  std::uint32_t queue_end_{};
  std::uint16_t growing_{};
  std::uint32_t region_at_{};    ///< that finish or merge looks at next
  std::uint32_t regions_end_{};  ///< none in use from here on
  std::uint32_t ids_{};
  UnitCredit credit_;
  PlaneGrowingCounts counts_;
};

}  // namespace sortie::mapping
