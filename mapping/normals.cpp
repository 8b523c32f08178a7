// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/normals.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/plane_solve.hpp"

namespace sortie::mapping {
namespace {
constexpr std::int32_t kCell = kContributionSteps;

/// Cells that can hold a point within 4 cells of one in another cell: 0 to 4 cells between them, 9 along a
/// line.
constexpr unsigned kMostNear = 9 * 9 * 9;

/// Corner of the block in each direction, relative to the one in the middle.
struct Shifts {
  std::int32_t x[kDirections]{};
  std::int32_t y[kDirections]{};
  std::int32_t z[kDirections]{};
  constexpr Shifts() {
    for (int d = 0; d < kDirections; ++d) {
      x[d] = (d % 3 - 1) * 4 * kCell;
      y[d] = (d / 3 % 3 - 1) * 4 * kCell;
      z[d] = (d / 9 - 1) * 4 * kCell;
    }
  }
};
constexpr Shifts kShift;

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

std::uint32_t contribution(const Centroid& c) {
  return NormalRecord::kAdded | c.x >> 7 | static_cast<std::uint32_t>(c.y >> 7) << 9 |
         static_cast<std::uint32_t>(c.z >> 7) << 18;
}

/// Adds a position, relative to the centre of the record's own cell, or takes it away.
template <bool kAdd>
inline void put(NormalRecord& r, std::int32_t x, std::int32_t y, std::int32_t z) {
  const std::int32_t s = kAdd ? 1 : -1;
  r.square[0] += static_cast<std::uint32_t>(s * x * x);
  r.square[1] += static_cast<std::uint32_t>(s * y * y);
  r.square[2] += static_cast<std::uint32_t>(s * z * z);
  r.product[0] += s * x * y;
  r.product[1] += s * x * z;
  r.product[2] += s * y * z;
  r.sum[0] += s * x;
  r.sum[1] += s * y;
  r.sum[2] += s * z;
  r.count = static_cast<std::uint16_t>(r.count + s);
}

/// Adds what another record sums up.
void put_all(NormalRecord& r, const NormalRecord& sums) {
  for (int i = 0; i < 3; ++i) {
    r.square[i] += sums.square[i];
    r.product[i] += sums.product[i];
    r.sum[i] += sums.sum[i];
  }
  r.count = static_cast<std::uint16_t>(r.count + sums.count);
}

/// A number in 1/32767, rounded.
std::int16_t short_of(double part) {
  return static_cast<std::int16_t>(static_cast<std::int32_t>(part * 32767.0 + 32768.5) - 32768);
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

/// Goes over the voxels within the radius of one: its position into their sums or out of them, and theirs
/// into its own. `all`: those of its own block and of blocks that are leaving, too.
template <bool kAdd>
void Normals::visit(RollingGrid& grid, const Around& around, unsigned cell, bool all) {
  const Block& here = grid.block(around.index);
  NormalRecord& own = grid.normal(here, cell);
  const Steps at = held(own.contributed, cell);
  const Steps middle = centre(cell);
  // First all that may be near, so that memory can answer for all of them at a time.
  struct Near {
    NormalRecord* record;
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
    if (!all && (direction == kHere || block.leaving != 0)) continue;
    for (std::uint64_t rest = reach & block.active; rest != 0; rest = without_lowest(rest)) {
      const unsigned b = lowest(rest);
      NormalRecord& record = grid.normal(block, b);
      __builtin_prefetch(&record, 1);
      __builtin_prefetch(&record.normal[2], 1);
      near[found++] = {&record, static_cast<std::uint8_t>(direction), static_cast<std::uint8_t>(b)};
    }
  }
  NormalRecord sums;  // by itself, so that it may stay in registers
  std::uint64_t hit[kDirections] = {};
  for (unsigned i = 0; i < found; ++i) {
    NormalRecord& other = *near[i].record;
    if (!other.added()) continue;
    const int direction = near[i].direction;
    const unsigned b = near[i].cell;
    const Steps shift{kShift.x[direction], kShift.y[direction], kShift.z[direction]};
    const Steps p = held(other.contributed, b);
    // As the block beside sees it.
    const Steps from{at.x - shift.x, at.y - shift.y, at.z - shift.z};
    const std::int32_t dx = p.x - from.x;
    const std::int32_t dy = p.y - from.y;
    const std::int32_t dz = p.z - from.z;
    if (dx * dx + dy * dy + dz * dz > squared_radius_) continue;
    const Steps c = centre(b);
    put<kAdd>(other, from.x - c.x, from.y - c.y, from.z - c.z);
    if (kAdd) put<true>(sums, p.x + shift.x - middle.x, p.y + shift.y - middle.y, p.z + shift.z - middle.z);
    hit[direction] |= cell_bit(b);
  }
  for (int direction = 0; direction < kDirections; ++direction) {
    if (hit[direction] != 0) mark(around.found[direction], hit[direction]);
  }
  if (kAdd) put_all(own, sums);
}

/// Voxels of a change that are new, or farther than allowed from where they were when they were added.
std::uint64_t Normals::far_off(const RollingGrid& grid, const BlockChange& change) const {
  const Block& block = grid.block(change.block);
  std::uint64_t far = 0;
  for (std::uint64_t rest = change.moved; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    const NormalRecord& own = grid.normal(block, cell);
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
  NormalRecord& own = grid.normal(block, cell);
  if (own.added()) {
    ++step.restated;
    visit<false>(grid, around, cell, true);
  }
  const std::int16_t normal[3] = {own.normal[0], own.normal[1], own.normal[2]};
  const std::uint16_t curvature = own.curvature;
  own = NormalRecord{};
  std::copy(normal, normal + 3, own.normal);
  own.curvature = curvature;
  own.contributed = contribution(grid.voxel(block, cell));
  const Steps at = held(own.contributed, cell);
  const Steps c = centre(cell);
  own.contributed &= ~NormalRecord::kAdded;
  visit<true>(grid, around, cell, true);
  put<true>(own, at.x - c.x, at.y - c.y, at.z - c.z);
  own.contributed |= NormalRecord::kAdded;
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
    if (grid.normal(block, cell).added()) visit<false>(grid, around, cell, false);
  }
  memory_.work[index].stale = 0;
  memory_.work[index].turned = 0;
}

NormalsStep Normals::update(RollingGrid& grid) {
  NormalsStep step;
  if (status_ != Status::ok) return step;
  for (std::uint32_t i = 0; i < done_; ++i) memory_.work[memory_.queue[i]].turned = 0;
  // What was solved leaves the queue; `done_` of it stayed for those who ask what turned.
  std::copy(memory_.queue.begin() + done_, memory_.queue.begin() + queued_, memory_.queue.begin());
  queued_ -= done_;
  done_ = 0;
  const std::span<const BlockChange> changes = grid.changes();
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (i + 1 < changes.size()) grid.prefetch_normals(grid.block(changes[i + 1].block), changes[i + 1].moved);
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
      grid.prefetch_normals(grid.block(next), memory_.work[next].stale);
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
  std::uint64_t turned = 0;
  for (std::uint64_t rest = cells & block.active; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    NormalRecord& r = grid.normal(block, cell);
    std::int16_t normal[3] = {0, 0, 0};
    std::uint16_t curvature = 0;
    PlaneFit fit;
    if (r.count >= config_.min_neighbours && fit_plane(scaled_covariance(r), fit)) {
      for (int axis = 0; axis < 3; ++axis) normal[axis] = short_of(fit.normal[axis]);
      curvature = static_cast<std::uint16_t>(fit.curvature * (3.0 * 65535.0));
    }
    if (coarse(normal, curvature) != coarse(r.normal, r.curvature)) turned |= cell_bit(cell);
    std::copy(normal, normal + 3, r.normal);
    r.curvature = curvature;
  }
  memory_.work[index].turned = turned;
}

}  // namespace sortie::mapping
