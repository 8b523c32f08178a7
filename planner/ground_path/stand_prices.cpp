// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/stand_prices.hpp"

#include <algorithm>

namespace sortie::planner {

StandPrices::StandPrices(const GroundPathConfig& config, const PostureSource& source,
                         std::span<std::uint8_t> memory)
    : footprints_(config),
      source_(source),
      reach_mm_(config.reach_mm),
      margin_(footprints_.reach() + config.posture_margin_cells) {
  const std::size_t cells = check(config) == Status::ok ? GroundMap::cells_for(config) : 0;
  if (memory.size() < cells * kBytesPerCell) return;
  std::fill(memory.begin(), memory.end(), kNotJudged);
  slots_ = memory.first(cells * 2 * kStandSlots);
  cores_ = memory.subspan(slots_.size(), cells * 2);
}

std::uint8_t StandPrices::price(const GroundMap& map, std::int32_t x, std::int32_t y, std::int32_t surface,
                                std::int32_t slot, std::uint64_t& units) {
  const std::size_t place = map.place(x, y, surface);
  std::uint8_t& known = slot == FootprintTable::kCore
                            ? cores_[place]
                            : slots_[place * kStandSlots + static_cast<std::size_t>(slot)];
  if (known == kNotJudged) known = judge(map, x, y, surface, slot, units);
  return known;
}

std::uint8_t StandPrices::judge(const GroundMap& map, std::int32_t x, std::int32_t y, std::int32_t surface,
                                std::int32_t slot, std::uint64_t& units) {
  const std::uint8_t ground = judge_ground(map, x, y, surface, slot, units);
  if (ground != 0 || slot == FootprintTable::kCore) return ground;
  if (slot >= kHeadings) {
    // Between two headings: the worse of both, whose ground is part of this one's.
    const std::int32_t from = slot - kHeadings;
    return std::max(price(map, x, y, surface, from, units),
                    price(map, x, y, surface, wrap_heading(from + 1), units));
  }
  if (source_.price == nullptr) return 0;
  units += source_.units;
  const std::uint8_t price = source_.price(source_.self, {x, y, surface, slot});
  return price == kBlockedStand ? kBlockedStand : std::min(price, kMostPrice);
}

// 0 where all of the footprint carries. Where the robot's middle stands on unknown ground no height is known,
// and any surface that carries will do: such a plan is a hope, and is planned again before it is driven.
std::uint8_t StandPrices::judge_ground(const GroundMap& map, std::int32_t x, std::int32_t y,
                                       std::int32_t surface, std::int32_t slot, std::uint64_t& units) const {
  units += 1;
  const GroundCell& middle = map.cell(x, y);
  const GroundState state = middle.state[surface];
  if (state == GroundState::blocked) return kBlockedStand;
  if (state == GroundState::unknown && (surface != 0 || !middle.is_unknown())) return kBlockedStand;
  const std::int32_t height_mm = middle.is_unknown() ? kNoHeight : middle.height_mm[surface];
  const std::int32_t reach = footprints_.reach(slot);
  if (!map.is_inside(x - reach, y - reach) || !map.is_inside(x + reach, y + reach)) {
    return kBlockedStand;
  }
  bool seen = true;
  for (std::int32_t dy = -reach; dy <= reach; ++dy) {
    const FootprintRow& row = footprints_.row(slot, dy);
    if (row.low > row.high) continue;
    units += static_cast<std::uint64_t>(row.high - row.low) / kCellsPerUnit;
    const GroundCell* cell = &map.cell(x + row.low, y + dy);
    for (std::int32_t dx = row.low; dx <= row.high; ++dx, ++cell) {
      if (cell->is_unknown()) {
        seen = false;
        continue;
      }
      if (height_mm == kNoHeight) {
        if (cell->state[0] != GroundState::carries && cell->state[1] != GroundState::carries)
          return kBlockedStand;
        continue;
      }
      const std::int32_t s = nearest_surface(*cell, height_mm, reach_mm_);
      if (s == kNoSurface || cell->state[s] == GroundState::blocked) return kBlockedStand;
    }
  }
  return seen ? std::uint8_t{0} : kUnknownStand;
}

bool StandPrices::refresh(GroundMap& map, std::uint64_t& units) {
  std::int32_t tile_x = 0;
  std::int32_t tile_y = 0;
  units += 1;
  if (!map.take_changed(tile_x, tile_y)) return false;
  const std::int32_t low_x = std::max(tile_x - margin_, 0);
  const std::int32_t high_x = std::min(tile_x + GroundMap::kTile + margin_, map.nx());
  const std::int32_t high_y = std::min(tile_y + GroundMap::kTile + margin_, map.ny());
  for (std::int32_t y = std::max(tile_y - margin_, 0); y < high_y; ++y) {
    const std::size_t first = 2 * map.index(low_x, y);
    const std::size_t count = 2 * static_cast<std::size_t>(high_x - low_x);
    const auto slots = slots_.subspan(first * kStandSlots, count * kStandSlots);
    std::fill(slots.begin(), slots.end(), kNotJudged);
    const auto cores = cores_.subspan(first, count);
    std::fill(cores.begin(), cores.end(), kNotJudged);
    units += count / 16;
  }
  return true;
}

}  // namespace sortie::planner
