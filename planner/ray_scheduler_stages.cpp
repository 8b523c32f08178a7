// SPDX-License-Identifier: BSD-3-Clause
// The order of the ray scheduler's stages, and when a candidate becomes the plan.
#include <algorithm>

#include "planner/ray_scheduler.hpp"
#include "planner/ray_units.hpp"

namespace sortie::planner {

namespace {
// Worths are summed in another order when a plan is weighed: a gain below this may be rounding.
constexpr double kSurely = 1.0 + 1e-6;
}  // namespace

std::uint32_t RayScheduler::advance() {
  switch (phase_) {
    case Phase::coarse:
      return trace_coarse();
    case Phase::seed_bound:
      return trace_seed();
    case Phase::select:
      return select_next();
    case Phase::decide:
      return decide();
    case Phase::weigh:
      return weigh_next();
    case Phase::clear:
      return clear_next();
    case Phase::reload:
      return reload_next();
    case Phase::next_stage:
      return next_stage();
    case Phase::explore:
      return explore_next();
    case Phase::trace_all:
      return trace_next();
    case Phase::certify:
      return certify_next();
    case Phase::done:
      break;
  }
  return 0;
}

// One coarse direction of the next position.
std::uint32_t RayScheduler::trace_coarse() {
  const std::uint32_t n = cursor_++;
  if (n >= sizes_.coarse()) {
    ++coarse_;
    phase_ = Phase::next_stage;
    return 1;
  }
  const std::uint32_t ray = coarse_ * sizes_.all_rays + sizes_.coarse_ray(config_, n);
  float worth{};
  return looks_.is_traced(ray) ? 1 : looks_.trace(ray, nullptr, worth);
}

// The worths of the seed's rays, each for itself, bound what the seed is worth: coverage is submodular.
std::uint32_t RayScheduler::trace_seed() {
  const std::uint32_t i = cursor_++;
  if (i >= plan_.positions * sizes_.per_position) {
    double sum = 0.0;
    for (const double bound : seed_bound_) sum += bound;
    best_ = {0.0, sum, false};
    phase_ = Phase::next_stage;
    return 1;
  }
  const std::uint32_t position = i / sizes_.per_position;
  const std::uint32_t ray = position * sizes_.all_rays + best_rays_[i];
  std::uint32_t cost = 1;
  float worth{};
  if (!looks_.is_traced(ray)) cost += looks_.trace(ray, nullptr, worth);
  seed_bound_[position] += static_cast<double>(looks_.fresh(ray));
  return cost;
}

// The next direction that was not traced yet, of any position.
std::uint32_t RayScheduler::trace_next() {
  const std::uint32_t ray = cursor_++;
  if (ray >= plan_.positions * sizes_.all_rays) {
    all_traced_ = true;
    start_selection(RayStage::exact, 0, plan_.positions);
    return 1;
  }
  float worth{};
  return looks_.is_traced(ray) ? 1 : looks_.trace(ray, nullptr, worth);
}

std::uint32_t RayScheduler::explore_next() {
  const std::uint32_t cost = exploration_.step();
  if (exploration_.done()) start_selection(RayStage::joint, 0, plan_.positions);
  return cost;
}

// Positions first .. last - 1 are chosen anew; those before stay, and stay in the cover.
void RayScheduler::start_selection(RayStage stage, std::uint32_t first, std::uint32_t last) {
  stage_ = stage;
  last_ = last;
  selection_.start(stage, first, last);
  phase_ = Phase::select;
  if (first == 0) clear_cover_then(Phase::select);
}

// What was chosen is worth what the cover says. Positions behind it are the seed's.
std::uint32_t RayScheduler::select_next() {
  const std::uint32_t cost = selection_.step(best_rays_);
  if (!selection_.done()) return cost;
  work_ = {cover_.worth(), selection_.is_whole() ? cover_.worth() : kUnknownBound, false};
  for (std::uint32_t p = last_; p < plan_.positions; ++p) work_.upper += seed_bound_[p];
  disturbed_ = false;
  phase_ = Phase::decide;
  return cost;
}

void RayScheduler::clear_cover_then(Phase phase) {
  after_clear_ = phase;
  phase_ = Phase::clear;
}

std::uint32_t RayScheduler::clear_next() {
  if (cover_.clear_some(ray_units::kLinesCleared)) phase_ = after_clear_;
  return ray_units::kLinesCleared;
}

// The candidate becomes the plan when it is surely worth more. Bounds mostly tell; where they do not, both
// are weighed, for the first position (its rays are fired next) and for whole plans.
std::uint32_t RayScheduler::decide() {
  const bool whole = last_ == plan_.positions;
  if (work_.lower > 0.0 && work_.lower >= best_.upper * kSurely) {
    adopt();
  } else if (last_ == 1 || whole) {
    const bool hopeless = work_.upper <= best_.lower * kSurely;
    if (!hopeless && !work_.weighed && !work_.is_exact()) {
      start_weighing(true);
      return 1;
    }
    if (!hopeless && !best_.weighed && !best_.is_exact()) {
      start_weighing(false);
      return 1;
    }
  }
  cursor_ = 0;
  phase_ = Phase::next_stage;
  if (disturbed_ && (!whole || stage_ == RayStage::exact)) clear_cover_then(Phase::reload);
  return static_cast<std::uint32_t>(ray_units::decided(plan_.positions * sizes_.per_position));
}

void RayScheduler::start_weighing(bool candidate) {
  candidate_weighed_ = candidate;
  disturbed_ = true;
  weighing_.begin();
  clear_cover_then(Phase::weigh);
}

std::uint32_t RayScheduler::weigh_next() {
  const std::uint32_t cost = weighing_.step(candidate_weighed_ ? selection_.rays() : best_rays_, cover_);
  if (!weighing_.done()) return cost;
  phase_ = Phase::decide;
  if (candidate_weighed_) {
    work_ = weighing_.bounds();
    // Both plans hold the same rays but for the first position's: the seed's add their own worths at most.
    if (last_ == 1 && plan_.stage == RayStage::seed)
      best_.upper = std::min(best_.upper, weighing_.rest_upper() + seed_bound_[0]);
  } else {
    best_ = weighing_.bounds();
    plan_.worth = best_.lower;
    plan_.exact_worth = best_.is_exact();
  }
  return cost;
}

// The candidate's positions up to here are entered again. What the cover does not take in this order is not
// held any more.
std::uint32_t RayScheduler::reload_next() {
  const std::uint32_t i = cursor_++;
  if (i >= last_ * sizes_.per_position) {
    phase_ = Phase::next_stage;
    return 1;
  }
  const std::uint32_t position = i / sizes_.per_position;
  if (!looks_.is_inside(position)) return 1;
  RayWorth worth;
  bool entered{};
  const std::uint32_t ray = position * sizes_.all_rays + selection_.rays()[i];
  const std::uint32_t cost = looks_.enter(ray, cover_, worth, entered);
  use_.refused = use_.refused || !entered;  // the bound is over what the table takes, and says so
  return cost;
}

std::uint32_t RayScheduler::next_stage() {
  const std::uint32_t positions = plan_.positions;
  const bool everything = sizes_.per_position == sizes_.all_rays;
  if (everything && stage_ == RayStage::seed) {
    // There is one plan only: what it is worth is all that is left to find out.
    stage_ = RayStage::exact;
    last_ = positions;
    work_ = {0.0, 0.0, true};
    start_weighing(false);
    return 1;
  }
  if (everything) {
    set_bound(best_.upper);
    return 1;
  }
  cursor_ = 0;
  // Coarse directions are looked at when they are needed, so that the next position's plan comes early.
  std::uint32_t coarse = config_.joint && stage_ < RayStage::joint ? positions : 0;
  if (config_.position_first && stage_ == RayStage::seed) coarse = 1;
  if (config_.position_first && stage_ == RayStage::position) coarse = std::min(last_ + 1, positions);
  if (coarse_ < coarse) {
    phase_ = Phase::coarse;
    return 1;
  }
  if (stage_ == RayStage::seed && config_.position_first) {
    start_selection(RayStage::position, 0, 1);
  } else if (stage_ == RayStage::position && last_ < positions) {
    start_selection(RayStage::position, last_, last_ + 1);
  } else if (stage_ < RayStage::joint && config_.joint) {
    exploration_.begin();
    phase_ = Phase::explore;
  } else if (stage_ < RayStage::exact && config_.exact) {
    phase_ = Phase::trace_all;
    stage_ = RayStage::exact;
  } else if (stage_ == RayStage::exact && config_.certify && all_traced_) {
    certificate_.begin();
    phase_ = Phase::certify;
  } else {
    phase_ = Phase::done;
  }
  return static_cast<std::uint32_t>(ray_units::started(std::uint64_t{positions} * sizes_.all_rays));
}

std::uint32_t RayScheduler::certify_next() {
  const std::uint32_t cost = certificate_.step(cover_);
  if (certificate_.done()) set_bound(certificate_.bound());
  return cost;
}

void RayScheduler::set_bound(double bound) {
  plan_.best_bound = bound;
  finish_certificate();
  phase_ = Phase::done;
}

void RayScheduler::finish_certificate() {
  plan_.certificate = plan_.best_bound > 0.0 ? std::min(plan_.worth / plan_.best_bound, 1.0) : 1.0;
}

}  // namespace sortie::planner
