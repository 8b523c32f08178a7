// SPDX-License-Identifier: BSD-3-Clause
// What it costs to stand somewhere: judged when it is first asked, kept until the ground nearby changes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "planner/ground_path/footprint.hpp"
#include "planner/ground_path/ground_map.hpp"
#include "rt/describe.hpp"

namespace sortie::planner {

/// A pose on the lattice.
struct GroundPose {
  std::int32_t x{};
  std::int32_t y{};
  std::int32_t surface{};  ///< of the cell
  std::int32_t heading{};  ///< 0 to 15
  SORTIE_FIELDS(x, y, surface, heading)
  friend constexpr bool operator==(const GroundPose&, const GroundPose&) = default;
};

/// Who knows what a posture costs: 0 to kMostPrice, or kBlockedStand. Asked only where all ground under the
/// robot carries. It must answer alike until GroundMap::touch() is called near the pose. None: all cost 0.
struct PostureSource {
  std::uint8_t (*price)(const void* self, const GroundPose& pose){};
  const void* self{};
  std::uint32_t units{};  ///< of work that an answer takes
  /// What any posture on a surface of a cell costs at least; the heading says nothing. Optional: the better
  /// it is, the less is searched. Asked for about every surface between start and goal.
  std::uint8_t (*least)(const void* self, const GroundPose& pose){};
};

/// Prices of all slots of all surfaces. Memory: 66 bytes a cell. No heap.
class StandPrices {
 public:
  /// Work units of a judged slot: one, and one for so many cells.
  static constexpr std::uint32_t kCellsPerUnit = 32;

  static std::size_t bytes_for(const GroundPathConfig& config) {
    return GroundMap::cells_for(config) * kBytesPerCell;
  }
  /// `memory` holds bytes_for() bytes; all are forgotten.
  StandPrices(const GroundPathConfig& config, const PostureSource& source, std::span<std::uint8_t> memory);

  /// 0 to kMostPrice, kUnknownStand or kBlockedStand for a surface of a cell inside of the map; `slot` also
  /// FootprintTable::kCore, whose price is 0 where it stands. Adds what it worked to `units`.
  std::uint8_t price(const GroundMap& map, std::int32_t x, std::int32_t y, std::int32_t surface,
                     std::int32_t slot, std::uint64_t& units);

  /// A price that no posture on the surface falls below, as far as the source tells.
  std::uint8_t least(std::int32_t x, std::int32_t y, std::int32_t surface) const {
    return source_.least == nullptr ? std::uint8_t{0}
                                    : std::min(source_.least(source_.self, {x, y, surface, 0}), kMostPrice);
  }

  /// Forgets what one changed tile can have changed; false when none did. Adds to `units`.
  bool refresh(GroundMap& map, std::uint64_t& units);

  /// Forgets all.
  void forget() {
    std::fill(slots_.begin(), slots_.end(), kNotJudged);
    std::fill(cores_.begin(), cores_.end(), kNotJudged);
  }

  const FootprintTable& footprints() const { return footprints_; }

 private:
  static constexpr std::size_t kBytesPerCell = 2 * (kStandSlots + 1);
  static constexpr std::uint8_t kNotJudged = 253;
  std::uint8_t judge(const GroundMap& map, std::int32_t x, std::int32_t y, std::int32_t surface,
                     std::int32_t slot, std::uint64_t& units);
  std::uint8_t judge_ground(const GroundMap& map, std::int32_t x, std::int32_t y, std::int32_t surface,
                            std::int32_t slot, std::uint64_t& units) const;

  FootprintTable footprints_;
  PostureSource source_;
  std::int32_t reach_mm_{};
  std::int32_t margin_{};
  std::span<std::uint8_t> slots_;
  std::span<std::uint8_t> cores_;
};

}  // namespace sortie::planner
