// SPDX-License-Identifier: BSD-3-Clause
// Ground maps and planners that own their memory, prices from a table, and maps that are drawn.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "planner/ground_path/ground_path.hpp"

namespace sortie::planner::test {

/// A small robot on cells of 10 cm.
inline GroundPathConfig small_ground(std::int32_t nx = 36, std::int32_t ny = 28) {
  GroundPathConfig config;
  config.nx = nx;
  config.ny = ny;
  config.half_length_mm = 110;
  config.half_width_mm = 70;
  return config;
}

/// How much memory a planner has.
struct GroundRoom {
  std::size_t columns{SIZE_MAX};
  std::size_t open{SIZE_MAX};
  std::size_t steps{1024};
  bool least{};  ///< the prices' least is known
};

/// Map, prices of postures and planner. Not to be moved.
struct OwnedGround {
  explicit OwnedGround(const GroundPathConfig& c, const GroundRoom& room = {})
      : config(c),
        cells(GroundMap::cells_for(c)),
        changed(GroundMap::tile_words_for(c)),
        map(c, cells, changed),
        postures(cells.size() * 2 * kHeadings),
        block(std::size_t{1} << 20),
        memory(sized(room)),
        path(c, {price_of, this, 0, room.least ? least_of : nullptr}, memory) {}
  OwnedGround(const OwnedGround&) = delete;

  std::uint8_t& posture(std::int32_t x, std::int32_t y, std::int32_t surface, std::int32_t heading) {
    return postures[(2 * map.index(x, y) + static_cast<std::size_t>(surface)) * kHeadings +
                    static_cast<std::size_t>(heading)];
  }
  static std::uint8_t price_of(const void* self, const GroundPose& p) {
    auto* mine = static_cast<OwnedGround*>(const_cast<void*>(self));
    return mine->posture(p.x, p.y, p.surface, p.heading);
  }
  static std::uint8_t least_of(const void* self, const GroundPose& p) {
    GroundPose pose = p;
    std::uint8_t least = kBlockedStand;
    for (pose.heading = 0; pose.heading < kHeadings; ++pose.heading)
      least = std::min(least, price_of(self, pose));
    return least;
  }
  void set(std::int32_t x, std::int32_t y, GroundState state, std::int32_t height_mm = 0) {
    GroundCell cell;
    cell.state[0] = state;
    cell.height_mm[0] = static_cast<std::int16_t>(height_mm);
    static_cast<void>(map.set(x, y, cell));
  }
  /// All of a rectangle, the higher corner left out; what lies outside of the map is left out too.
  void fill(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1, GroundState state,
            std::int32_t height_mm = 0) {
    for (std::int32_t y = std::max(y0, 0); y < std::min(y1, config.ny); ++y)
      for (std::int32_t x = std::max(x0, 0); x < std::min(x1, config.nx); ++x) set(x, y, state, height_mm);
  }
  /// Plans to the end, or until the units are spent.
  GroundPathState plan(const GroundPose& start, const GroundPose& goal, std::uint64_t units = UINT64_MAX) {
    static_cast<void>(path.begin(map, start, goal));
    return path.run(map, units);
  }

  GroundPathConfig config;
  std::vector<GroundCell> cells;
  std::vector<std::uint64_t> changed;
  GroundMap map;
  std::vector<std::uint8_t> postures;
  std::vector<std::byte> block;
  GroundPathMemory memory;
  GroundPath path;

 private:
  GroundPathMemory sized(const GroundRoom& room) {
    rt::Arena asked(block);
    static_cast<void>(GroundPathMemory::take(asked, config, room.columns, room.open, room.steps));
    block.resize(asked.needed_bytes());
    rt::Arena arena(block);
    return GroundPathMemory::take(arena, config, room.columns, room.open, room.steps);
  }
};

/// A whole number from 0 to n - 1.
inline std::int32_t draw_below(std::mt19937& random, std::int32_t n) {
  return static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(n));
}

/// Kinds of maps: blocks; rooms with doors; two floors with ramps; patches that were not seen; rough ground.
inline constexpr std::uint32_t kGroundKinds = 5;

/// A mezzanine over part of the map, on which ramps lead up; between its floors nobody can step.
inline void build_mezzanine(OwnedGround& g, std::mt19937& random) {
  const std::int32_t nx = g.config.nx;
  const std::int32_t ny = g.config.ny;
  constexpr std::int32_t kHigh = 1400;
  const std::int32_t edge = nx / 2 + draw_below(random, 3);
  const std::int32_t ramp = 5 + draw_below(random, 3);
  const std::int32_t ramp_y = draw_below(random, ny - ramp);
  const std::int32_t length = 10;
  for (std::int32_t y = 0; y < ny; ++y) {
    for (std::int32_t x = 0; x < nx; ++x) {
      GroundCell cell;
      cell.state[0] = GroundState::carries;
      if (x >= edge) {
        // Which of both comes first must not matter.
        const std::int32_t high = (x + y) % 2;
        cell.state[1] = GroundState::carries;
        cell.height_mm[high] = kHigh;
      } else if (x >= edge - length && y >= ramp_y && y < ramp_y + ramp) {
        cell.height_mm[0] = static_cast<std::int16_t>(kHigh * (x - edge + length + 1) / (length + 1));
      }
      static_cast<void>(g.map.set(x, y, cell));
    }
  }
  // Pillars on both floors.
  for (int i = 0; i < 6; ++i) {
    const std::int32_t x = edge + draw_below(random, nx - edge);
    const std::int32_t y = draw_below(random, ny);
    GroundCell cell = g.map.cell(x, y);
    cell.state[draw_below(random, 2)] = GroundState::blocked;
    static_cast<void>(g.map.set(x, y, cell));
  }
}

/// Draws map and prices of a kind; most can be crossed.
inline void draw_ground(OwnedGround& g, std::mt19937& random, std::uint32_t kind) {
  const std::int32_t nx = g.config.nx;
  const std::int32_t ny = g.config.ny;
  g.fill(0, 0, nx, ny, GroundState::carries);
  if (kind == 1) {
    for (std::int32_t x = 9; x < nx; x += 10) {
      g.fill(x, 0, x + 1, ny, GroundState::blocked);
      for (int door = 0; door < 2; ++door) {
        const std::int32_t y = draw_below(random, ny - 4);
        g.fill(x, y, x + 1, y + 4 + draw_below(random, 3), GroundState::carries);
      }
    }
  }
  if (kind == 2) build_mezzanine(g, random);
  const std::int32_t blocks = kind == 0 ? nx * ny / 40 : nx * ny / 200;
  for (std::int32_t i = 0; i < blocks && kind != 2; ++i)
    g.set(draw_below(random, nx), draw_below(random, ny), GroundState::blocked);
  for (int i = 0; i < 5 && kind == 3; ++i) {
    const std::int32_t x = draw_below(random, nx);
    const std::int32_t y = draw_below(random, ny);
    g.fill(x, y, x + 2 + draw_below(random, 8), y + 2 + draw_below(random, 8), GroundState::unknown);
  }
  if (kind == 4) {
    for (std::int32_t y = 0; y < ny; ++y)
      for (std::int32_t x = 0; x < nx; ++x)
        g.set(x, y, GroundState::carries, 60 * x % 700 + draw_below(random, 120));
  }
  // Dear patches, along some headings more than along others, and postures that are impossible.
  for (int i = 0; i < 6; ++i) {
    const std::int32_t x0 = draw_below(random, nx);
    const std::int32_t y0 = draw_below(random, ny);
    const std::int32_t size = 2 + draw_below(random, 8);
    const auto dear = static_cast<std::uint8_t>(draw_below(random, 120));
    for (std::int32_t y = y0; y < std::min(y0 + size, ny); ++y) {
      for (std::int32_t x = x0; x < std::min(x0 + size, nx); ++x) {
        for (std::int32_t h = 0; h < kHeadings; ++h) {
          const auto price = static_cast<std::uint8_t>(dear + draw_below(random, 60));
          g.posture(x, y, 0, h) = random() % 64 == 0 ? kBlockedStand : price;
          g.posture(x, y, 1, h) = price;
        }
      }
    }
  }
  g.map.touch(0, 0);
}

/// A pose of a column of cells and of any surface there; it may be on blocked ground.
inline GroundPose draw_pose(const OwnedGround& g, std::mt19937& random, std::int32_t low_x,
                            std::int32_t high_x) {
  GroundPose pose;
  pose.x = low_x + draw_below(random, high_x - low_x);
  pose.y = 3 + draw_below(random, g.config.ny - 6);
  const bool two = g.map.cell(pose.x, pose.y).state[1] != GroundState::unknown;
  pose.surface = two ? draw_below(random, 2) : 0;
  pose.heading = draw_below(random, kHeadings);
  return pose;
}

inline std::vector<GroundPose> poses_of(std::span<const GroundStep> way) {
  std::vector<GroundPose> poses;
  for (const GroundStep& step : way) poses.push_back(step.pose);
  return poses;
}

// A hall of carrying ground with a wall across it, whose gap is at the top.
inline void build_wall(OwnedGround& g) {
  g.fill(0, 0, g.config.nx, g.config.ny, GroundState::carries);
  g.fill(16, 0, 17, g.config.ny - 8, GroundState::blocked);
}

inline constexpr GroundPose kWest{6, 8, 0, 0};
inline constexpr GroundPose kEast{28, 8, 0, 0};

}  // namespace sortie::planner::test
