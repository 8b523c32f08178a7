// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ray_exploration.hpp"

#include "planner/ray_units.hpp"

namespace sortie::planner {

void RayExploration::begin() {
  cursor_ = 0;
  done_ = false;
  heap_.clear();
}

std::uint32_t RayExploration::step() {
  if (cursor_ < looks_.positions() * sizes_.coarse()) {
    const std::uint32_t position = cursor_ / sizes_.coarse();
    const std::uint32_t n = cursor_++ % sizes_.coarse();
    const std::uint32_t ray = position * sizes_.all_rays + sizes_.coarse_ray(config_, n);
    return RayNode::push(heap_, ray, config_.coarse_log2, looks_.fresh(ray));
  }
  if (heap_.empty() || !heap_.has_room(4) || looks_.traced() >= looks_.positions() * config_.explored) {
    done_ = true;
    return 1;
  }
  const std::uint64_t top = heap_.top();
  const std::uint32_t node = RayKey::node(top);
  const std::uint32_t level = RayNode::level(node);
  heap_.pop();
  if (level == 0) return ray_units::kHeap;
  const std::uint32_t columns = config_.sensor.columns;
  const std::uint32_t base = looks_.position_of(RayNode::ray(node)) * sizes_.all_rays;
  const std::uint32_t corner = RayNode::ray(node) - base;
  const float inherited = 0.5f * RayKey::worth(top);
  std::uint32_t cost = ray_units::kHeap;
  for (std::uint32_t child = 0; child < 4; ++child) {
    const std::uint32_t x = corner % columns + ((child & 1u) << (level - 1));
    const std::uint32_t y = corner / columns + ((child >> 1) << (level - 1));
    if (x >= columns || y >= config_.sensor.rows) continue;
    const std::uint32_t ray = base + y * columns + x;
    float worth{};
    if (looks_.is_traced(ray))
      worth = looks_.fresh(ray);
    else
      cost += looks_.trace(ray, nullptr, worth);
    if (level > 1) cost += RayNode::push(heap_, ray, level - 1, worth > inherited ? worth : inherited);
  }
  return cost;
}

}  // namespace sortie::planner
