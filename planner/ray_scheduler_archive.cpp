// SPDX-License-Identifier: BSD-3-Clause
// What the ray scheduler carries from one task to the next, to bytes and back.
#include "planner/ray_scheduler.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

// The plan alone: begin() makes everything else anew.
void RayScheduler::archive(rt::Archive& archive) {
  archive.expect(usable_ ? sizes_.all_rays : 0, "the scheduler has other directions");
  archive.expect(sizes_.per_position, "the scheduler plans another number of rays");
  archive.expect(config_.positions, "the scheduler plans another number of positions");
  RayPlan plan = plan_;
  archive.value(plan);
  for (std::uint16_t& ray : best_rays_) {
    archive.value(ray);
    if (ray < sizes_.all_rays) continue;
    archive.fail(Status::malformed, "a direction that the sensor does not have");
    ray = 0;
  }
  if (!archive.is_reading()) return;
  if (plan.positions > config_.positions || static_cast<std::uint32_t>(plan.stage) > 3) {
    archive.fail(Status::malformed, "a plan that the scheduler cannot have made");
    plan = {};
  }
  plan_ = plan;
  phase_ = Phase::done;
  credit_ = 0;
}

}  // namespace sortie::planner
