// SPDX-License-Identifier: BSD-3-Clause
// The ground as the planner sees it: up to two surfaces a cell, and whether each was seen to carry.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "planner/ground_path/ground_config.hpp"

namespace sortie::planner {

/// What is known of a surface.
enum class GroundState : std::uint8_t {
  unknown,  ///< not seen; as the second surface: there is none
  carries,  ///< seen, or felt by the tracks
  blocked,  ///< seen, and it does not carry: a wall, a hole, what is too steep
};

/// Surfaces of a cell, in any order: the floor, and a second one above or below. 6 bytes.
struct GroundCell {
  std::int16_t height_mm[2]{};
  GroundState state[2]{};
  friend constexpr bool operator==(const GroundCell&, const GroundCell&) = default;

  bool is_unknown() const { return state[0] == GroundState::unknown && state[1] == GroundState::unknown; }
};

inline constexpr std::int32_t kNoSurface = -1;
/// A height that nobody knows: the robot's middle would stand on a cell that was not seen.
inline constexpr std::int32_t kNoHeight = INT32_MIN;

/// The known surface of a cell that is nearest to a height, the first of two; kNoSurface where none lies
/// within reach. For kNoHeight the first known one. The cell is not unknown.
constexpr std::int32_t nearest_surface(const GroundCell& cell, std::int32_t height_mm,
                                       std::int32_t reach_mm) {
  std::int32_t best = kNoSurface;
  std::int32_t best_mm = reach_mm + 1;
  for (std::int32_t s = 0; s < 2; ++s) {
    if (cell.state[s] == GroundState::unknown) continue;
    if (height_mm == kNoHeight) return s;
    const std::int32_t apart = cell.height_mm[s] - height_mm;
    const std::int32_t apart_mm = apart < 0 ? -apart : apart;
    if (apart_mm >= best_mm) continue;
    best = s;
    best_mm = apart_mm;
  }
  return best;
}

/// Cells in rows along x. Remembers which tiles of 8 x 8 cells changed until somebody takes them: a map
/// serves one planner, another one would not hear of what that took. Memory: 6 bytes a cell and a bit a tile,
/// the caller's. No heap.
class GroundMap {
 public:
  static constexpr std::int32_t kTile = 8;

  /// Cells and words of bits that a configuration needs.
  static std::size_t cells_for(const GroundPathConfig& config) {
    return static_cast<std::size_t>(config.nx) * static_cast<std::size_t>(config.ny);
  }
  static std::size_t tile_words_for(const GroundPathConfig& config) {
    return (tiles(config.nx) * tiles(config.ny) + 63) / 64;
  }

  /// All cells are unknown until they are set. An empty map where the memory does not fit the configuration:
  /// then nothing is inside.
  GroundMap(const GroundPathConfig& config, std::span<GroundCell> cells, std::span<std::uint64_t> changed)
      : cells_(cells), changed_(changed) {
    if (check(config) != Status::ok || cells.size() < cells_for(config) ||
        changed.size() < tile_words_for(config))
      return;
    nx_ = config.nx;
    ny_ = config.ny;
    tiles_x_ = static_cast<std::int32_t>(tiles(nx_));
    // What the memory held before says nothing.
    std::fill(cells_.begin(), cells_.end(), GroundCell{});
    std::fill(changed_.begin(), changed_.end(), std::uint64_t{0});
  }

  std::int32_t nx() const { return nx_; }
  std::int32_t ny() const { return ny_; }
  bool is_inside(std::int32_t x, std::int32_t y) const { return x >= 0 && y >= 0 && x < nx_ && y < ny_; }
  std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(nx_) + static_cast<std::size_t>(x);
  }
  /// Number of a surface of a cell, for tables.
  std::uint32_t place(std::int32_t x, std::int32_t y, std::int32_t surface) const {
    return 2 * static_cast<std::uint32_t>(index(x, y)) + static_cast<std::uint32_t>(surface);
  }
  const GroundCell& cell(std::int32_t x, std::int32_t y) const { return cells_[index(x, y)]; }

  /// Says what is in a cell. out_of_range outside of the map, or for a state that there is not.
  Status set(std::int32_t x, std::int32_t y, const GroundCell& cell) {
    if (!is_inside(x, y) || cell.state[0] > GroundState::blocked || cell.state[1] > GroundState::blocked)
      return Status::out_of_range;
    GroundCell& mine = cells_[index(x, y)];
    if (mine == cell) return Status::ok;
    mine = cell;
    touch(x, y);
    return Status::ok;
  }
  /// What a PostureSource says about a cell's surroundings changed, though the cell did not.
  void touch(std::int32_t x, std::int32_t y) {
    if (!is_inside(x, y)) return;
    const auto tile = static_cast<std::uint32_t>(y / kTile * tiles_x_ + x / kTile);
    changed_[tile / 64] |= std::uint64_t{1} << (tile % 64);
    ++version_;
  }

  /// Takes the corner of one tile that changed; false when there is none. Cost: a look at each word.
  bool take_changed(std::int32_t& x, std::int32_t& y);

  /// Rises with every change.
  std::uint32_t version() const { return version_; }

 private:
  static constexpr std::size_t tiles(std::int32_t n) {
    return static_cast<std::size_t>((n + kTile - 1) / kTile);
  }

  std::span<GroundCell> cells_;
  std::span<std::uint64_t> changed_;
  std::int32_t nx_{};
  std::int32_t ny_{};
  std::int32_t tiles_x_{};
  std::uint32_t version_{};
};

}  // namespace sortie::planner
