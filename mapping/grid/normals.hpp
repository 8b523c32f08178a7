// SPDX-License-Identifier: BSD-3-Clause
// Normals and curvature of a rolling grid's voxels, kept up to date as voxels come, move and go.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/reach.hpp"
#include "mapping/grid/rolling_grid.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Settings of the normals.
struct NormalsConfig {
  double radius_m{0.3};             ///< of the neighbourhood: more than 0, at most 4 voxels
  double restate_m{0.03};           ///< a voxel that moved farther than this along an axis is added anew
  std::uint32_t min_neighbours{3};  ///< a voxel with fewer, itself among them, has no normal: at least 3
  std::uint32_t solves{0};          ///< most normals computed a tick; 0: all there are

  SORTIE_KEYS(c, key) {
    key("normal_radius_m", c.radius_m, {0.001, 40, "m", "neighbourhood of a normal"});
    key("restate_m", c.restate_m, {0, 10, "m", "a voxel that moved farther is added anew to normals"});
    key("solves", c.solves, {0, 1e6, "normals", "most that a scan may compute; 0: no limit"});
  }
};

/// What the normals know of a block: voxels whose sums changed since their normal was computed.
struct NormalWork {
  std::uint64_t stale{};
  std::uint64_t turned{};  ///< voxels whose coarse() normal is another one after the newest update
  bool queued{};
};

/// Memory: value-initialised arrays.
struct NormalsMemory {
  std::span<NormalWork> work;   ///< one a block of the grid
  std::span<BlockIndex> queue;  ///< two a block: what was done stays readable while more comes in
};

/// What one tick did, and what is left to do.
struct NormalsStep {
  std::uint32_t added{};     ///< voxels whose position went into the sums of their neighbours
  std::uint32_t restated{};  ///< those among them that had been there before
  std::uint32_t solved{};    ///< normals computed
  std::uint32_t backlog{};   ///< blocks with voxels whose sums changed and whose normals wait
  SORTIE_FIELDS(added, restated, solved, backlog)
};

/// Every active voxel adds its position to the sums of the voxels within the radius, takes theirs, and takes
/// its own away again when it goes or is added anew. Sums are whole numbers relative to cells: whatever the
/// history, they are those of a batch over the positions held. No heap.
class Normals {
 public:
  /// A grid without normal records, a radius beyond 4 voxels or a lack of memory: see status().
  Normals(const NormalsConfig& config, const RollingGrid& grid, const NormalsMemory& memory);

  Status status() const { return status_; }

  /// Takes the positions of a block that is about to be given back out of the sums of its neighbours.
  void forget(RollingGrid& grid, BlockIndex block);
  /// Takes the changes of the newest scan in and computes what became stale, within the budget.
  NormalsStep update(RollingGrid& grid);

  /// Blocks in which normals changed in the newest update are those with turned(block) != 0.
  std::span<const BlockIndex> turned_blocks() const { return memory_.queue.first(done_); }
  std::uint64_t turned(BlockIndex block) const { return memory_.work[block].turned; }

 private:
  struct Around;
  std::uint64_t far_off(const RollingGrid& grid, const BlockChange& change) const;
  void add(RollingGrid& grid, const Around& around, unsigned cell, NormalsStep& step);
  template <bool kWas, bool kIs>
  void visit(RollingGrid& grid, const Around& around, unsigned cell, std::uint32_t was, std::uint32_t is,
             NormalSums& own);
  void mark(BlockIndex block, std::uint64_t cells);
  void solve(RollingGrid& grid, BlockIndex block, std::uint64_t cells);

  NormalsConfig config_;
  Reach reach_;
  NormalsMemory memory_;
  Status status_;
  std::int32_t squared_radius_{};
  std::int32_t restate_{};
  std::uint32_t queued_{};
  std::uint32_t done_{};
};

}  // namespace sortie::mapping
