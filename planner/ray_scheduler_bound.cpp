// SPDX-License-Identifier: BSD-3-Clause
// The certificate of a plan of rays.
//
// Coverage is monotone and submodular, so for any set S and the best plan O:
//     worth(O) <= worth(S) + sum over positions of the K greatest worths beside S.
// S is what the exact stage chose. Old worths bound new ones from above, so only those that come to the top
// of the heap are computed again. Nothing is assumed about how good S is.
#include <cmath>

#include "planner/ray_scheduler.hpp"
#include "planner/ray_units.hpp"

namespace sortie::planner {

std::uint32_t RayScheduler::certify_build_next() {
  const std::uint32_t index = cursor_++;
  if (index == 0) {
    heap_.clear();
    marginal_sum_ = 0.0;
    for (std::uint32_t& count : counts_) count = 0;
    left_ = plan_.positions * per_position_;
  }
  if (index >= plan_.positions * all_rays_) {
    phase_ = Phase::certify;
    tried_ = 0;
    return 1;
  }
  // A chosen ray has nothing to add.
  if (bit(chosen_, index)) return 1;
  return push_ray(index / all_rays_, index % all_rays_, 0, fresh_[index]);
}

std::uint32_t RayScheduler::certify_next() {
  if (left_ == 0 || heap_.empty() || !(RayKey::worth(heap_.top()) > 0.0f)) {
    // A part in a million for the rounding of a long sum and of worths kept as floats.
    const double bound = (chosen_worth_ + marginal_sum_) * (1.0 + 1e-6);
    plan_.best_bound = bound < plan_.best_bound ? bound : plan_.best_bound;
    finish_certificate();
    phase_ = Phase::done;
    return 1;
  }
  const std::uint64_t top = heap_.top();
  const std::uint32_t index = RayKey::node(top);
  const std::uint32_t position = index / all_rays_;
  if (counts_[position] >= per_position_) {
    heap_.pop();
    return ray_units::kHeap;
  }
  std::uint32_t cost = ray_units::kHeap;
  if (top != tried_) {
    float worth{};
    cost += evaluate(index, worth);
    const std::uint64_t key = RayKey::make(worth, index);
    const bool first = key > heap_.second();
    heap_.replace_top(key);
    if (!first) {
      tried_ = key > tried_ ? key : tried_;
      return cost;
    }
  }
  marginal_sum_ += static_cast<double>(RayKey::worth(heap_.top()));
  heap_.pop();
  ++counts_[position];
  --left_;
  tried_ = 0;
  return cost + ray_units::kHeap;
}

void RayScheduler::finish_certificate() {
  plan_.certificate = plan_.best_bound > 0.0 ? plan_.worth / plan_.best_bound : 1.0;
  if (plan_.certificate > 1.0) plan_.certificate = 1.0;
}

}  // namespace sortie::planner
