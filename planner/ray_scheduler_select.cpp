// SPDX-License-Identifier: BSD-3-Clause
// Lazy greedy choice (Minoux 1978) among directions that are refined where it pays.
//
// The heap holds rays with upper bounds of their worth and, in guided stages, cells of directions of which
// only a corner was looked at, with a guess. What comes to the top is looked at again: a ray that stays
// before all others is taken; a cell that does is split into four.
#include <algorithm>

#include "planner/ray_scheduler.hpp"
#include "planner/ray_units.hpp"

namespace sortie::planner {

namespace {
constexpr std::uint32_t kLevelShift = 28;
constexpr std::uint32_t kIndexMask = (1u << kLevelShift) - 1;
}  // namespace

// Traces a direction for the first time. `beside`: its worth beside the rays of the table is wanted, too.
std::uint32_t RayScheduler::trace(std::uint32_t position, std::uint32_t ray, bool beside, float& worth) {
  const std::uint32_t index = position * all_rays_ + ray;
  ++plan_.traced;
  set_bit(traced_, index);
  fresh_[index] = 0.0f;
  path_[index] = 0;
  worth = 0.0f;
  if (!views_[position].inside) return ray_units::kRay;
  const mapping::VoxelWalk way = walk(position, ray);
  RayWorth found;
  if (paths_.begin(most_cells_)) {
    found = beside ? model_.both(way, map_.cells, table_, paths_) : model_.fresh(way, map_.cells, paths_);
    path_[index] = paths_.end(way);
  } else {
    found = beside ? model_.both(way, map_.cells, table_) : model_.fresh(way, map_.cells);
  }
  fresh_[index] = static_cast<float>(found.fresh);
  worth = static_cast<float>(found.current);
  return ray_units::kRay + found.cells * (beside ? ray_units::kCellBeside : ray_units::kCell);
}

// A ray's worth beside those of the table. It was traced in this task, as all rays that are looked at, chosen
// or weighed: so its path is of this task, too.
std::uint32_t RayScheduler::evaluate(std::uint32_t node, float& worth) {
  const std::uint32_t index = node & kIndexMask;
  const std::uint32_t position = index / all_rays_;
  worth = 0.0f;
  ++plan_.evaluations;
  if (!views_[position].inside) return ray_units::kRay;
  const std::uint32_t path = path_[index];
  const RayWorth found =
      path > 0 ? model_.current(paths_.path(path, views_[position].cell), map_.cells, table_)
               : model_.current(walk(position, index - position * all_rays_), map_.cells, table_);
  worth = static_cast<float>(found.current);
  return ray_units::kRay + found.cells * (path > 0 ? ray_units::kCellAgain : ray_units::kCellBeside);
}

// Enters a ray in the table, if that takes it.
std::uint32_t RayScheduler::cover(std::uint32_t position, std::uint32_t ray, RayWorth& worth, bool& entered) {
  const std::uint32_t path = path_[position * all_rays_ + ray];
  entered = path > 0
                ? model_.cover(paths_.path(path, views_[position].cell), map_.cells, table_, scratch_, worth)
                : model_.cover(walk(position, ray), map_.cells, table_, scratch_, worth);
  return ray_units::kRay + worth.cells * ray_units::kCellTaken;
}

std::uint32_t RayScheduler::push_ray(std::uint32_t position, std::uint32_t ray, std::uint32_t level,
                                     float worth) {
  if (!heap_.push(RayKey::make(worth, level << kLevelShift | (position * all_rays_ + ray))))
    plan_.heap_full = true;
  return ray_units::kHeap;
}

// What lies below a cell whose corner is traced: the cell itself, or what it was split into before.
std::uint32_t RayScheduler::push_cell(std::uint32_t position, std::uint32_t x, std::uint32_t y,
                                      std::uint32_t level) {
  if (level == 0) return 0;
  const std::uint32_t half = 1u << (level - 1);
  const std::uint32_t columns = config_.sensor.columns;
  const std::uint32_t base = position * all_rays_;
  bool split = true;
  for (std::uint32_t child = 1; child < 4; ++child) {
    const std::uint32_t cx = x + (child & 1u) * half;
    const std::uint32_t cy = y + (child >> 1) * half;
    if (cx < columns && cy < config_.sensor.rows) split = split && bit(traced_, base + cy * columns + cx);
  }
  const std::uint32_t corner = y * columns + x;
  if (!split) {
    const auto guess = static_cast<float>(config_.optimism * static_cast<double>(fresh_[base + corner]));
    return push_ray(position, corner, level, guess);
  }
  std::uint32_t cost = push_cell(position, x, y, level - 1);
  for (std::uint32_t child = 1; child < 4; ++child) {
    const std::uint32_t cx = x + (child & 1u) * half;
    const std::uint32_t cy = y + (child >> 1) * half;
    if (cx >= columns || cy >= config_.sensor.rows) continue;
    cost += push_ray(position, cy * columns + cx, 0, fresh_[base + cy * columns + cx]);
    cost += push_cell(position, cx, cy, level - 1);
  }
  return cost;
}

// Fills the heap: one coarse cell of directions, or one direction of the exact stage.
std::uint32_t RayScheduler::build_next() {
  const std::uint32_t coarse = coarse_columns_ * coarse_rows_;
  const bool exact = stage_ == RayStage::exact;
  const std::uint32_t each = exact ? all_rays_ : coarse;
  const std::uint32_t i = cursor_++;
  if (i >= (last_ - first_) * each) {
    phase_ = Phase::select;
    return 1;
  }
  const std::uint32_t position = first_ + i / each;
  const std::uint32_t n = i % each;
  if (exact) return push_ray(position, n, 0, fresh_[position * all_rays_ + n]);
  const std::uint32_t x = n % coarse_columns_ << config_.coarse_log2;
  const std::uint32_t y = n / coarse_columns_ << config_.coarse_log2;
  const std::uint32_t corner = y * config_.sensor.columns + x;
  const std::uint32_t cost = push_ray(position, corner, 0, fresh_[position * all_rays_ + corner]);
  return cost + push_cell(position, x, y, config_.coarse_log2);
}

// Looks at what is on top. The choice is that of plain greedy, ties to the lower position and number, but
// for `slack` and `tries` of the guided stages.
std::uint32_t RayScheduler::select_next() {
  if (heap_.empty() || !(RayKey::worth(heap_.top()) > 0.0f)) {
    phase_ = Phase::complete;
    cursor_ = first_;
    return 1;
  }
  const std::uint64_t top = heap_.top();
  const std::uint32_t node = RayKey::node(top);
  const std::uint32_t index = node & kIndexMask;
  const std::uint32_t level = node >> kLevelShift;
  const bool over = counts_[index / all_rays_] >= per_position_ || (level == 0 && bit(chosen_, index));
  if (over) {
    heap_.pop();
    return ray_units::kHeap;
  }
  if (level == 0 && top == tried_) return take(node) + ray_units::kHeap;  // evaluated for this very choice
  const bool guided = stage_ != RayStage::exact;
  const std::uint32_t tries = stage_ == RayStage::position ? (config_.tries + 5) / 6 : config_.tries;
  if (guided && tries_ >= tries && tried_ != 0) return take(RayKey::node(tried_));
  // A chosen corner says nothing any more about the rest of its cell.
  if (level > 0 && bit(chosen_, index)) return refine(node);
  float worth{};
  std::uint32_t cost = evaluate(node, worth) + ray_units::kHeap;
  if (level > 0) {
    const std::uint64_t key =
        RayKey::make(static_cast<float>(config_.optimism * static_cast<double>(worth)), node);
    if (key > heap_.second()) return cost + refine(node);
    heap_.replace_top(key);
    return cost;
  }
  ++tries_;
  const std::uint64_t key = RayKey::make(worth, node);
  const std::uint64_t second = heap_.second();
  const double enough = guided ? 1.0 - config_.slack : 1.0;
  heap_.replace_top(key);
  if (key > second ||
      (guided && static_cast<double>(worth) > enough * static_cast<double>(RayKey::worth(second))))
    return cost + take(node);
  tried_ = std::max(tried_, key);
  return cost;
}

// A ray is chosen. It may stay in the heap: it is passed over when it comes up.
std::uint32_t RayScheduler::take(std::uint32_t node) {
  const std::uint32_t index = node & kIndexMask;
  const std::uint32_t position = index / all_rays_;
  const std::uint32_t ray = index - position * all_rays_;
  RayWorth worth;
  bool entered{};
  const std::uint32_t cost = cover(position, ray, worth, entered);
  if (!entered) {
    plan_.table_full = true;
    phase_ = Phase::complete;
    cursor_ = first_;
    return cost;
  }
  if (RayKey::node(heap_.top()) == node) heap_.pop();
  set_bit(chosen_, index);
  work_rays_[position * per_position_ + counts_[position]++] = static_cast<std::uint16_t>(ray);
  chosen_worth_ += worth.current;
  plan_.table_used = std::max(plan_.table_used, table_.used());
  tries_ = 0;
  tried_ = 0;
  if (--left_ == 0) {
    phase_ = Phase::complete;
    cursor_ = first_;
  }
  return cost;
}

// Splits the cell on top: three directions are looked at, and four smaller cells take its place.
std::uint32_t RayScheduler::refine(std::uint32_t node) {
  const std::uint32_t index = node & kIndexMask;
  const std::uint32_t level = node >> kLevelShift;
  const std::uint32_t position = index / all_rays_;
  const std::uint32_t columns = config_.sensor.columns;
  const std::uint32_t corner = index - position * all_rays_;
  const std::uint32_t x = corner % columns;
  const std::uint32_t y = corner / columns;
  const std::uint32_t half = 1u << (level - 1);
  heap_.pop();
  if (!heap_.has_room(8)) {
    plan_.heap_full = true;
    return ray_units::kHeap;
  }
  std::uint32_t cost = ray_units::kHeap + push_cell(position, x, y, level - 1);
  for (std::uint32_t child = 1; child < 4; ++child) {
    const std::uint32_t cx = x + (child & 1u) * half;
    const std::uint32_t cy = y + (child >> 1) * half;
    if (cx >= columns || cy >= config_.sensor.rows) continue;
    const std::uint32_t ray = cy * columns + cx;
    float worth = fresh_[position * all_rays_ + ray];
    if (!bit(traced_, position * all_rays_ + ray)) cost += trace(position, ray, true, worth);
    cost += push_ray(position, ray, 0, worth);
    const auto guess = static_cast<float>(config_.optimism * static_cast<double>(worth));
    if (level > 1) cost += push_ray(position, ray, level - 1, guess);
  }
  return cost;
}

// Looks at directions where the best ones are: a cell is split whose corner, or half the cell that it was
// split from, is worth most.
std::uint32_t RayScheduler::explore_next() {
  const std::uint32_t coarse = coarse_columns_ * coarse_rows_;
  if (cursor_ < plan_.positions * coarse) {
    const std::uint32_t position = cursor_ / coarse;
    const std::uint32_t n = cursor_++ % coarse;
    const std::uint32_t ray = (n / coarse_columns_ << config_.coarse_log2) * config_.sensor.columns +
                              (n % coarse_columns_ << config_.coarse_log2);
    return push_ray(position, ray, config_.coarse_log2, fresh_[position * all_rays_ + ray]);
  }
  if (heap_.empty() || !heap_.has_room(4) || plan_.traced >= plan_.positions * config_.explored) {
    start_selection(RayStage::joint, 0, plan_.positions);
    return 1;
  }
  const std::uint64_t top = heap_.top();
  const std::uint32_t node = RayKey::node(top);
  const std::uint32_t index = node & kIndexMask;
  const std::uint32_t level = node >> kLevelShift;
  heap_.pop();
  if (level == 0) return ray_units::kHeap;
  const std::uint32_t position = index / all_rays_;
  const std::uint32_t columns = config_.sensor.columns;
  const std::uint32_t corner = index - position * all_rays_;
  const float inherited = 0.5f * RayKey::worth(top);
  std::uint32_t cost = ray_units::kHeap;
  for (std::uint32_t child = 0; child < 4; ++child) {
    const std::uint32_t x = corner % columns + ((child & 1u) << (level - 1));
    const std::uint32_t y = corner / columns + ((child >> 1) << (level - 1));
    if (x >= columns || y >= config_.sensor.rows) continue;
    const std::uint32_t ray = y * columns + x;
    float worth = fresh_[position * all_rays_ + ray];
    if (!bit(traced_, position * all_rays_ + ray)) cost += trace(position, ray, false, worth);
    if (level > 1) cost += push_ray(position, ray, level - 1, worth > inherited ? worth : inherited);
  }
  return cost;
}

}  // namespace sortie::planner
