// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ray_selection.hpp"

#include <algorithm>

#include "planner/ray_units.hpp"

namespace sortie::planner {

void RaySelection::start(RayStage stage, std::uint32_t first, std::uint32_t last) {
  stage_ = stage;
  first_ = first;
  last_ = last;
  for (std::uint32_t p = first; p < last; ++p) counts_[p] = 0;
  left_ = (last - first) * sizes_.per_position;
  heap_.clear();
  tries_ = 0;
  tried_ = 0;
  cursor_ = 0;
  phase_ = Phase::build;
}

bool RaySelection::is_whole() const {
  for (std::uint32_t p = 0; p < last_; ++p) {
    if (counts_[p] < sizes_.per_position) return false;
  }
  return true;
}

std::uint32_t RaySelection::step(std::span<const std::uint16_t> best) {
  switch (phase_) {
    case Phase::build:
      return build_next();
    case Phase::select:
      return select_next();
    case Phase::complete:
      return complete_next(best);
    case Phase::done:
      break;
  }
  return 0;
}

// What lies below a cell whose corner is traced: the cell itself, or what it was split into before.
std::uint32_t RaySelection::push_cell(std::uint32_t base, std::uint32_t x, std::uint32_t y,
                                      std::uint32_t level) {
  if (level == 0) return 0;
  const std::uint32_t half = 1u << (level - 1);
  const std::uint32_t columns = config_.sensor.columns;
  bool split = true;
  for (std::uint32_t child = 1; child < 4; ++child) {
    const std::uint32_t cx = x + (child & 1u) * half;
    const std::uint32_t cy = y + (child >> 1) * half;
    if (cx < columns && cy < config_.sensor.rows) split = split && looks_.is_traced(base + cy * columns + cx);
  }
  const std::uint32_t corner = base + y * columns + x;
  if (!split) {
    const auto guess = static_cast<float>(config_.optimism * static_cast<double>(looks_.fresh(corner)));
    return RayNode::push(heap_, corner, level, guess);
  }
  std::uint32_t cost = push_cell(base, x, y, level - 1);
  for (std::uint32_t child = 1; child < 4; ++child) {
    const std::uint32_t cx = x + (child & 1u) * half;
    const std::uint32_t cy = y + (child >> 1) * half;
    if (cx >= columns || cy >= config_.sensor.rows) continue;
    const std::uint32_t ray = base + cy * columns + cx;
    cost += RayNode::push(heap_, ray, 0, looks_.fresh(ray));
    cost += push_cell(base, cx, cy, level - 1);
  }
  return cost;
}

// Fills the heap: one coarse cell of directions, or one direction of the exact stage.
std::uint32_t RaySelection::build_next() {
  const bool exact = stage_ == RayStage::exact;
  const std::uint32_t each = exact ? sizes_.all_rays : sizes_.coarse();
  const std::uint32_t i = cursor_++;
  if (i >= (last_ - first_) * each) {
    phase_ = Phase::select;
    return 1;
  }
  const std::uint32_t base = (first_ + i / each) * sizes_.all_rays;
  const std::uint32_t n = i % each;
  if (exact) return RayNode::push(heap_, base + n, 0, looks_.fresh(base + n));
  const std::uint32_t corner = sizes_.coarse_ray(config_, n);
  const std::uint32_t cost = RayNode::push(heap_, base + corner, 0, looks_.fresh(base + corner));
  return cost + push_cell(base, corner % config_.sensor.columns, corner / config_.sensor.columns,
                          config_.coarse_log2);
}

void RaySelection::complete() {
  phase_ = Phase::complete;
  cursor_ = first_;
}

// Looks at what is on top. The choice is that of plain greedy, ties to the lower position and number, but
// for `slack` and `tries` of the guided stages.
std::uint32_t RaySelection::select_next() {
  if (heap_.empty() || !(RayKey::worth(heap_.top()) > 0.0f)) {
    complete();
    return 1;
  }
  const std::uint64_t top = heap_.top();
  const std::uint32_t node = RayKey::node(top);
  const std::uint32_t ray = RayNode::ray(node);
  const std::uint32_t level = RayNode::level(node);
  const bool over =
      counts_[looks_.position_of(ray)] >= sizes_.per_position || (level == 0 && cover_.holds(ray));
  if (over) {
    heap_.pop();
    return ray_units::kHeap;
  }
  if (level == 0 && top == tried_) return take(node) + ray_units::kHeap;  // evaluated for this very choice
  const bool guided = stage_ != RayStage::exact;
  const std::uint32_t tries = stage_ == RayStage::position ? (config_.tries + 5) / 6 : config_.tries;
  if (guided && tries_ >= tries && tried_ != 0) return take(RayKey::node(tried_));
  // A chosen corner says nothing any more about the rest of its cell.
  if (level > 0 && cover_.holds(ray)) return refine(node);
  float worth{};
  std::uint32_t cost = looks_.evaluate(ray, cover_, worth) + ray_units::kHeap;
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
std::uint32_t RaySelection::take(std::uint32_t node) {
  const std::uint32_t ray = RayNode::ray(node);
  const std::uint32_t position = looks_.position_of(ray);
  RayWorth worth;
  bool entered{};
  const std::uint32_t cost = looks_.enter(ray, cover_, worth, entered);
  if (!entered) {
    use_.refused = true;
    complete();
    return cost;
  }
  if (RayKey::node(heap_.top()) == node) heap_.pop();
  rays_[position * sizes_.per_position + counts_[position]++] =
      static_cast<std::uint16_t>(ray - position * sizes_.all_rays);
  use_.most_lines = std::max(use_.most_lines, cover_.table().used());
  tries_ = 0;
  tried_ = 0;
  if (--left_ == 0) complete();
  return cost;
}

// Splits the cell on top: three directions are looked at, and four smaller cells take its place.
std::uint32_t RaySelection::refine(std::uint32_t node) {
  const std::uint32_t level = RayNode::level(node);
  const std::uint32_t columns = config_.sensor.columns;
  const std::uint32_t base = looks_.position_of(RayNode::ray(node)) * sizes_.all_rays;
  const std::uint32_t x = (RayNode::ray(node) - base) % columns;
  const std::uint32_t y = (RayNode::ray(node) - base) / columns;
  const std::uint32_t half = 1u << (level - 1);
  heap_.pop();
  if (!heap_.has_room(8)) {
    heap_.note_refusal();
    return ray_units::kHeap;
  }
  std::uint32_t cost = ray_units::kHeap + push_cell(base, x, y, level - 1);
  for (std::uint32_t child = 1; child < 4; ++child) {
    const std::uint32_t cx = x + (child & 1u) * half;
    const std::uint32_t cy = y + (child >> 1) * half;
    if (cx >= columns || cy >= config_.sensor.rows) continue;
    const std::uint32_t ray = base + cy * columns + cx;
    float worth{};
    if (looks_.is_traced(ray))
      worth = looks_.fresh(ray);
    else
      cost += looks_.trace(ray, &cover_, worth);
    cost += RayNode::push(heap_, ray, 0, worth);
    const auto guess = static_cast<float>(config_.optimism * static_cast<double>(worth));
    if (level > 1) cost += RayNode::push(heap_, ray, level - 1, guess);
  }
  return cost;
}

// A position whose rays ran out of worth, or of table, is filled from the best plan. The cover holds what was
// chosen, and only that.
std::uint32_t RaySelection::complete_next(std::span<const std::uint16_t> best) {
  const std::uint32_t position = cursor_++;
  if (position >= last_) {
    phase_ = Phase::done;
    return 1;
  }
  const std::uint32_t place = position * sizes_.per_position;
  std::uint32_t filled = counts_[position];
  for (std::uint32_t i = 0; i < sizes_.per_position && filled < sizes_.per_position; ++i) {
    if (!cover_.holds(position * sizes_.all_rays + best[place + i]))
      rays_[place + filled++] = best[place + i];
  }
  return 2 * sizes_.per_position + 1;
}

}  // namespace sortie::planner
