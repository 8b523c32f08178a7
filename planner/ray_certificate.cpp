// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ray_certificate.hpp"

#include "planner/ray_units.hpp"

namespace sortie::planner {

void RayCertificate::begin() {
  cursor_ = 0;
  left_ = looks_.positions() * sizes_.per_position;
  for (std::uint32_t& count : counts_) count = 0;
  tried_ = 0;
  sum_ = 0.0;
  filled_ = false;
  done_ = false;
  heap_.clear();
}

std::uint32_t RayCertificate::fill_next(const RayCover& cover) {
  const std::uint32_t ray = cursor_++;
  if (ray >= looks_.positions() * sizes_.all_rays) {
    filled_ = true;
    return 1;
  }
  // A ray of S has nothing to add.
  if (cover.holds(ray)) return 1;
  (void)heap_.push(RayKey::make(looks_.fresh(ray), ray));
  return ray_units::kHeap;
}

std::uint32_t RayCertificate::find_next(const RayCover& cover) {
  if (left_ == 0 || heap_.empty() || !(RayKey::worth(heap_.top()) > 0.0f)) {
    // A part in a million for the rounding of a long sum and of worths kept as floats.
    bound_ = (cover.worth() + sum_) * (1.0 + 1e-6);
    done_ = true;
    return 1;
  }
  const std::uint64_t top = heap_.top();
  const std::uint32_t ray = RayKey::node(top);
  const std::uint32_t position = looks_.position_of(ray);
  if (counts_[position] >= sizes_.per_position) {
    heap_.pop();
    return ray_units::kHeap;
  }
  std::uint32_t cost = ray_units::kHeap;
  if (top != tried_) {
    float worth{};
    cost += looks_.evaluate(ray, cover, worth);
    const std::uint64_t key = RayKey::make(worth, ray);
    const bool first = key > heap_.second();
    heap_.replace_top(key);
    if (!first) {
      tried_ = key > tried_ ? key : tried_;
      return cost;
    }
  }
  sum_ += static_cast<double>(RayKey::worth(heap_.top()));
  heap_.pop();
  ++counts_[position];
  --left_;
  tried_ = 0;
  return cost + ray_units::kHeap;
}

}  // namespace sortie::planner
