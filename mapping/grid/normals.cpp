// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/grid/normals.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/grid/plane_batch.hpp"

namespace sortie::mapping {
namespace {
constexpr std::int32_t kCell = kContributionSteps;

/// Cells that can hold a point within 4 cells of one in another cell: 0 to 4 cells between them, 9 along a
/// line.
constexpr unsigned kMostNear = 9 * 9 * 9;

struct Steps {
  std::int32_t x;
  std::int32_t y;
  std::int32_t z;
};

/// Where a voxel stood when it was added, relative to the corner of its block.
inline Steps held(std::uint32_t contributed, unsigned cell) {
  const auto in_cell = [contributed](int axis) { return contributed >> (9 * axis) & 511u; };
  return {static_cast<std::int32_t>((cell & 3) * kCell + in_cell(0)),
          static_cast<std::int32_t>((cell >> 2 & 3) * kCell + in_cell(1)),
          static_cast<std::int32_t>((cell >> 4) * kCell + in_cell(2))};
}

inline std::int32_t squared(const Steps& a, const Steps& b) {
  const std::int32_t x = a.x - b.x;
  const std::int32_t y = a.y - b.y;
  const std::int32_t z = a.z - b.z;
  return x * x + y * y + z * z;
}

std::uint32_t contribution(const Centroid& c) {
  return NormalSums::kAdded | c.x >> 7 | static_cast<std::uint32_t>(c.y >> 7) << 9 |
         static_cast<std::uint32_t>(c.z >> 7) << 18;
}

/// Adds a position, relative to the centre of the record's own cell, or takes it away.
template <bool kAdd>
inline void put(NormalSums& r, std::int32_t x, std::int32_t y, std::int32_t z) {
  const std::int32_t s = kAdd ? 1 : -1;
  r.square[0] += static_cast<std::uint32_t>(s * x * x);
  r.square[1] += static_cast<std::uint32_t>(s * y * y);
  r.square[2] += static_cast<std::uint32_t>(s * z * z);
  r.product[0] += s * x * y;
  r.product[1] += s * x * z;
  r.product[2] += s * y * z;
  if (kAdd) {
    r.sum += PackedSum::of(x, y, z);
  } else {
    r.sum -= PackedSum::of(x, y, z);
  }
  r.count = static_cast<std::uint16_t>(r.count + s);
}

/// Centre of a cell, relative to the corner of its block.
inline Steps centre(unsigned cell) {
  return {static_cast<std::int32_t>(cell & 3) * kCell + kCell / 2,
          static_cast<std::int32_t>(cell >> 2 & 3) * kCell + kCell / 2,
          static_cast<std::int32_t>(cell >> 4) * kCell + kCell / 2};
}
}  // namespace

/// A block and those around it.
struct Normals::Around {
  BlockIndex index{};
  BlockIndex found[kDirections]{};
};

Normals::Normals(const NormalsConfig& config, const RollingGrid& grid, const NormalsMemory& memory)
    : config_(config), reach_(config.radius_m / grid.config().voxel_size_m), memory_(memory) {
  const double cells = config.radius_m / grid.config().voxel_size_m;
  const double restate = config.restate_m / grid.config().voxel_size_m * kCell;
  const bool good = cells > 0 && cells <= Reach::kMostCells && restate >= 0 && restate < 1e6 &&
                    config.min_neighbours >= 3 && grid.holds_normals() &&
                    memory.work.size() >= grid.blocks().size() &&
                    memory.queue.size() / 2 >= grid.blocks().size();
  status_ = good ? Status::ok : Status::out_of_range;
  if (!good) return;
  squared_radius_ = static_cast<std::int32_t>(cells * kCell * (cells * kCell));
  restate_ = static_cast<std::int32_t>(restate);
}

void Normals::mark(BlockIndex block, std::uint64_t cells) {
  NormalWork& work = memory_.work[block];
  work.stale |= cells;
  if (work.queued) return;
  work.queued = true;
  memory_.queue[queued_++] = block;
}

/// Goes over the voxels that are, or were, within the radius of one: takes its old position out of their sums
/// and puts the new one in, and theirs into its own sums. A voxel that leaves has none new; then those of its
/// own block and of blocks that are leaving, too, are left out.
template <bool kWas, bool kIs>
void Normals::visit(RollingGrid& grid, const Around& around, unsigned cell, std::uint32_t was,
                    std::uint32_t is, NormalSums& own) {
  const Steps before = held(was, cell);
  const Steps now = held(is, cell);
  const Steps middle = centre(cell);
  // First all that may be near, so that memory can answer for all of them at a time.
  struct Near {
    NormalSums* record;
    std::uint8_t direction;
    std::uint8_t cell;
  };
  Near near[kMostNear];
  unsigned found = 0;
  for (int direction = 0; direction < kDirections; ++direction) {
    const BlockIndex index = around.found[direction];
    const std::uint64_t reach = reach_.from(cell, direction);
    if (index == kNoBlock || reach == 0) continue;
    const Block& block = grid.block(index);
    if (!kIs && (direction == kHere || block.leaving != 0)) continue;
    for (std::uint64_t rest = reach & block.active; rest != 0; rest = without_lowest(rest)) {
      const unsigned b = lowest(rest);
      NormalSums& record = grid.sums(block, b);
      __builtin_prefetch(&record, 1);
      __builtin_prefetch(&record.count, 1);
      near[found++] = {&record, static_cast<std::uint8_t>(direction), static_cast<std::uint8_t>(b)};
    }
  }
  NormalSums sums;  // by itself, so that it may stay in registers
  std::uint64_t hit[kDirections] = {};
  for (unsigned i = 0; i < found; ++i) {
    NormalSums& other = *near[i].record;
    if (!other.added()) continue;
    const int direction = near[i].direction;
    const unsigned b = near[i].cell;
    const BlockAt& way = kDirectionSteps.to[direction];
    const Steps shift{4 * kCell * way.x, 4 * kCell * way.y, 4 * kCell * way.z};
    const Steps there = held(other.contributed, b);
    const Steps p{there.x + shift.x, there.y + shift.y, there.z + shift.z};
    const Steps c = centre(b);
    const Steps origin{c.x + shift.x, c.y + shift.y, c.z + shift.z};
    const bool had = kWas && squared(p, before) <= squared_radius_;
    const bool has = kIs && squared(p, now) <= squared_radius_;
    if (had) put<false>(other, before.x - origin.x, before.y - origin.y, before.z - origin.z);
    if (has) {
      put<true>(other, now.x - origin.x, now.y - origin.y, now.z - origin.z);
      put<true>(sums, p.x - middle.x, p.y - middle.y, p.z - middle.z);
    }
    if (had || has) hit[direction] |= cell_bit(b);
  }
  for (int direction = 0; direction < kDirections; ++direction) {
    if (hit[direction] != 0) mark(around.found[direction], hit[direction]);
  }
  if (kIs) own = sums;
}

/// Voxels of a change that are new, or farther than allowed from where they were when they were added.
std::uint64_t Normals::far_off(const RollingGrid& grid, const BlockChange& change) const {
  const Block& block = grid.block(change.block);
  std::uint64_t far = 0;
  for (std::uint64_t rest = change.moved; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    const NormalSums& own = grid.sums(block, cell);
    const Steps is = held(contribution(grid.voxel(block, cell)), cell);
    const Steps was = held(own.contributed, cell);
    if (!own.added() || std::abs(is.x - was.x) > restate_ || std::abs(is.y - was.y) > restate_ ||
        std::abs(is.z - was.z) > restate_)
      far |= cell_bit(cell);
  }
  return far;
}

void Normals::add(RollingGrid& grid, const Around& around, unsigned cell, NormalsStep& step) {
  const Block& block = grid.block(around.index);
  NormalSums& own = grid.sums(block, cell);
  const std::uint32_t is = contribution(grid.voxel(block, cell));
  const std::uint32_t was = own.contributed;
  own.contributed = 0;  // not its own neighbour
  if ((was & NormalSums::kAdded) != 0) {
    ++step.restated;
    visit<true, true>(grid, around, cell, was, is, own);
  } else {
    visit<false, true>(grid, around, cell, 0, is, own);
  }
  own.contributed = is;
  const Steps at = held(is, cell);
  const Steps c = centre(cell);
  put<true>(own, at.x - c.x, at.y - c.y, at.z - c.z);
  mark(around.index, cell_bit(cell));
  ++step.added;
}

void Normals::forget(RollingGrid& grid, BlockIndex index) {
  if (status_ != Status::ok) return;
  const Block& block = grid.block(index);
  Around around;
  around.index = index;
  grid.around(block, around.found);
  for (std::uint64_t rest = block.active; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    NormalSums& own = grid.sums(block, cell);
    if (own.added()) visit<true, false>(grid, around, cell, own.contributed, 0, own);
  }
  memory_.work[index].stale = 0;
  memory_.work[index].turned = 0;
}

NormalsStep Normals::update(RollingGrid& grid) {
  NormalsStep step;
  if (status_ != Status::ok) return step;
  for (std::uint32_t i = 0; i < done_; ++i) memory_.work[memory_.queue[i]].turned = 0;
  // What was solved leaves the queue; `done_` of it stayed for those who ask what turned.
  const auto waiting = memory_.queue.subspan(done_, queued_ - done_);
  std::copy(waiting.begin(), waiting.end(), memory_.queue.begin());
  queued_ -= done_;
  done_ = 0;
  const std::span<const BlockChange> changes = grid.changes();
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (i + 1 < changes.size()) grid.prefetch_sums(grid.block(changes[i + 1].block), changes[i + 1].moved);
    if (i + 2 < changes.size()) __builtin_prefetch(&grid.block(changes[i + 2].block));
    const BlockChange& change = changes[i];
    if (change.moved == 0) continue;
    const std::uint64_t far = far_off(grid, change);
    if (far == 0) continue;
    Around around;
    around.index = change.block;
    grid.around(grid.block(change.block), around.found);
    for (std::uint64_t rest = far; rest != 0; rest = without_lowest(rest))
      add(grid, around, lowest(rest), step);
  }
  const std::uint32_t most = config_.solves > 0 ? config_.solves : 0xffffffffu;
  while (done_ < queued_ && step.solved < most) {
    const BlockIndex block = memory_.queue[done_++];
    NormalWork& work = memory_.work[block];
    work.queued = false;
    const std::uint64_t cells = work.stale;
    work.stale = 0;
    if (cells == 0 || !grid.block(block).in_use()) continue;
    if (done_ < queued_) {
      const BlockIndex next = memory_.queue[done_];
      grid.prefetch_sums(grid.block(next), memory_.work[next].stale);
    }
    if (done_ + 1 < queued_) {
      __builtin_prefetch(&grid.block(memory_.queue[done_ + 1]));
      __builtin_prefetch(&memory_.work[memory_.queue[done_ + 1]]);
    }
    step.solved += bits_in(cells & grid.block(block).active);
    solve(grid, block, cells);
  }
  step.backlog = queued_ - done_;
  return step;
}

void Normals::solve(RollingGrid& grid, BlockIndex index, std::uint64_t cells) {
  const Block& block = grid.block(index);
  PlaneBatch batch;
  std::uint32_t slots[Block::kCells];
  std::uint64_t fitted = 0;
  for (std::uint64_t rest = cells & block.active; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    slots[cell] = block.slot(block.rank(cell));
    const NormalSums& r = grid.sums()[slots[cell]];
    if (r.count < config_.min_neighbours) continue;
    batch.add(scaled_covariance(r));
    fitted |= cell_bit(cell);
  }
  batch.solve();
  std::uint64_t turned = 0;
  unsigned n = 0;
  for (std::uint64_t rest = cells & block.active; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    const SurfaceNormal is = (fitted & cell_bit(cell)) != 0 ? batch.plane(n++) : SurfaceNormal{};
    SurfaceNormal& was = grid.normals()[slots[cell]];
    if (coarse(is) != coarse(was)) turned |= cell_bit(cell);
    was = is;
  }
  memory_.work[index].turned = turned;
}

}  // namespace sortie::mapping
