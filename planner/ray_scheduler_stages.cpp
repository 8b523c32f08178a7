// SPDX-License-Identifier: BSD-3-Clause
// The order of the ray scheduler's stages, when a candidate becomes the plan, and what is proved about it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/ray_scheduler.hpp"
#include "planner/ray_units.hpp"

namespace sortie::planner {

namespace {
constexpr double kUnknownBound = std::numeric_limits<double>::infinity();
// Worths are summed in another order when a plan is weighed: a gain below this may be rounding.
constexpr double kSurely = 1.0 + 1e-6;
}  // namespace

std::uint32_t RayScheduler::advance() {
  switch (phase_) {
    case Phase::coarse:
      return trace_coarse();
    case Phase::seed_bound:
      return trace_seed();
    case Phase::build:
      return build_next();
    case Phase::select:
      return select_next();
    case Phase::complete:
      return complete_next();
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
    case Phase::certify_build:
      return certify_build_next();
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
  if (n >= coarse_columns_ * coarse_rows_) {
    ++coarse_;
    phase_ = Phase::next_stage;
    return 1;
  }
  const std::uint32_t ray = (n / coarse_columns_ << config_.coarse_log2) * config_.sensor.columns +
                            (n % coarse_columns_ << config_.coarse_log2);
  float worth{};
  return bit(traced_, coarse_ * all_rays_ + ray) ? 1 : trace(coarse_, ray, false, worth);
}

// The worths of the seed's rays, each for itself, bound what the seed is worth: coverage is submodular.
std::uint32_t RayScheduler::trace_seed() {
  const std::uint32_t i = cursor_++;
  if (i >= plan_.positions * per_position_) {
    double sum = 0.0;
    for (const double bound : seed_bound_) sum += bound;
    best_ = {0.0, sum, false};
    phase_ = Phase::next_stage;
    return 1;
  }
  const std::uint32_t position = i / per_position_;
  const std::uint32_t index = position * all_rays_ + best_rays_[i];
  std::uint32_t cost = 1;
  float worth{};
  if (!bit(traced_, index)) cost += trace(position, best_rays_[i], false, worth);
  seed_bound_[position] += static_cast<double>(fresh_[index]);
  return cost;
}

// The next direction that was not traced yet, of any position.
std::uint32_t RayScheduler::trace_next() {
  const std::uint32_t index = cursor_++;
  if (index >= plan_.positions * all_rays_) {
    all_traced_ = true;
    start_selection(RayStage::exact, 0, plan_.positions);
    return 1;
  }
  float worth{};
  return bit(traced_, index) ? 1 : trace(index / all_rays_, index % all_rays_, false, worth);
}

// Positions first .. last - 1 are chosen anew; those before stay, and stay in the table.
void RayScheduler::start_selection(RayStage stage, std::uint32_t first, std::uint32_t last) {
  stage_ = stage;
  first_ = first;
  last_ = last;
  for (std::uint32_t p = first; p < last; ++p) counts_[p] = 0;
  std::fill(chosen_.begin(), chosen_.end(), 0u);
  left_ = (last - first) * per_position_;
  heap_.clear();
  tries_ = 0;
  tried_ = 0;
  cursor_ = 0;
  phase_ = Phase::build;
  if (first == 0) {
    chosen_worth_ = 0.0;
    clear_table_then(Phase::build);
  }
}

void RayScheduler::clear_table_then(Phase phase) {
  after_clear_ = phase;
  phase_ = Phase::clear;
}

std::uint32_t RayScheduler::clear_next() {
  if (table_.clear_some(ray_units::kLinesCleared)) phase_ = after_clear_;
  return ray_units::kLinesCleared;
}

// A position whose rays ran out of worth, or of table, is filled from the best plan and the pattern. Nothing
// is said of what those rays are worth.
std::uint32_t RayScheduler::complete_next() {
  const std::uint32_t position = cursor_++;
  if (position >= last_) {
    work_ = {chosen_worth_, chosen_worth_, false};
    for (std::uint32_t p = 0; p < last_; ++p) {
      if (counts_[p] < per_position_) work_.upper = kUnknownBound;
    }
    for (std::uint32_t p = last_; p < plan_.positions; ++p) work_.upper += seed_bound_[p];
    disturbed_ = false;
    phase_ = Phase::decide;
    return 1;
  }
  const std::uint32_t base = position * per_position_;
  std::uint32_t filled = counts_[position];
  const auto add = [&](std::uint32_t ray) {
    if (filled >= per_position_ || bit(chosen_, position * all_rays_ + ray)) return;
    set_bit(chosen_, position * all_rays_ + ray);
    work_rays_[base + filled++] = static_cast<std::uint16_t>(ray);
  };
  for (std::uint32_t i = 0; i < per_position_; ++i) add(best_rays_[base + i]);
  // Only what is in the table counts as chosen.
  for (std::uint32_t i = counts_[position]; i < filled; ++i)
    chosen_[(position * all_rays_ + work_rays_[base + i]) >> 5] &=
        ~(1u << ((position * all_rays_ + work_rays_[base + i]) & 31u));
  return 2 * per_position_ + 1;
}

// The candidate becomes the plan when it is surely worth more. Bounds mostly tell; where they do not, both
// are weighed, for the first position (its rays are fired next) and for whole plans.
std::uint32_t RayScheduler::decide() {
  const bool whole = last_ == plan_.positions;
  if (work_.lower > 0.0 && work_.lower >= best_.upper * kSurely) {
    adopt();
  } else if (last_ == 1 || whole) {
    const bool hopeless = work_.upper <= best_.lower * kSurely;
    if (!hopeless && !work_.weighed && work_.lower < work_.upper) {
      start_weighing(true);
      return 1;
    }
    if (!hopeless && !best_.weighed && best_.lower < best_.upper) {
      start_weighing(false);
      return 1;
    }
  }
  cursor_ = 0;
  phase_ = Phase::next_stage;
  if (disturbed_ && (!whole || stage_ == RayStage::exact)) {
    chosen_worth_ = 0.0;
    clear_table_then(Phase::reload);
  }
  return static_cast<std::uint32_t>(ray_units::decided(plan_.positions * per_position_));
}

void RayScheduler::start_weighing(bool candidate) {
  candidate_weighed_ = candidate;
  disturbed_ = true;
  cursor_ = 0;
  (candidate ? work_ : best_) = {0.0, 0.0, true};
  clear_table_then(Phase::weigh);
}

// Each ray's worth beside those before it, the last position first. A ray that the table does not take counts
// in the upper bound.
std::uint32_t RayScheduler::weigh_next() {
  const std::uint32_t i = cursor_++;
  Bounds& bounds = candidate_weighed_ ? work_ : best_;
  if (i >= plan_.positions * per_position_) {
    if (!candidate_weighed_) {
      plan_.worth = bounds.lower;
      plan_.exact_worth = !(bounds.lower < bounds.upper);
    } else if (last_ == 1 && plan_.stage == RayStage::seed) {
      // Both plans hold the same rays but for the first position's: the seed's add their own worths at most.
      best_.upper = std::min(best_.upper, rest_upper_ + seed_bound_[0]);
    }
    phase_ = Phase::decide;
    return 1;
  }
  const std::uint32_t position = plan_.positions - 1 - i / per_position_;
  if (position == 0 && i % per_position_ == 0) rest_upper_ = bounds.upper;
  if (!views_[position].inside) return 1;
  RayWorth worth;
  const std::size_t place = std::size_t{position} * per_position_ + i % per_position_;
  const std::uint16_t ray = candidate_weighed_ ? work_rays_[place] : best_rays_[place];
  bool entered{};
  const std::uint32_t cost = cover(position, ray, worth, entered);
  if (entered) bounds.lower += worth.current;
  plan_.table_full = plan_.table_full || !entered;
  bounds.upper += worth.current;
  plan_.table_used = std::max(plan_.table_used, table_.used());
  return cost;
}

// The table again as it was: the candidate's positions up to here.
std::uint32_t RayScheduler::reload_next() {
  const std::uint32_t i = cursor_++;
  if (i >= last_ * per_position_) {
    phase_ = Phase::next_stage;
    return 1;
  }
  const std::uint32_t position = i / per_position_;
  if (!views_[position].inside) return 1;
  RayWorth worth;
  bool entered{};
  const std::uint32_t cost = cover(position, work_rays_[i], worth, entered);
  // What the table does not take this time, in another order, is not chosen any more.
  if (entered) chosen_worth_ += worth.current;
  plan_.table_full = plan_.table_full || !entered;  // the bound is over what the table takes, and says so
  put_bit(chosen_, position * all_rays_ + work_rays_[i], entered);
  return cost;
}

std::uint32_t RayScheduler::next_stage() {
  const std::uint32_t positions = plan_.positions;
  const bool everything = per_position_ == all_rays_;
  if (everything && stage_ == RayStage::seed) {
    // There is one plan only: what it is worth is all that is left to find out.
    stage_ = RayStage::exact;
    last_ = positions;
    work_ = {0.0, 0.0, true};
    start_weighing(false);
    return 1;
  }
  if (everything) {
    plan_.best_bound = best_.upper;
    finish_certificate();
    phase_ = Phase::done;
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
    heap_.clear();
    phase_ = Phase::explore;
  } else if (stage_ < RayStage::exact && config_.exact) {
    phase_ = Phase::trace_all;
    stage_ = RayStage::exact;
  } else if (stage_ == RayStage::exact && config_.certify && phase_ == Phase::next_stage && all_traced_) {
    phase_ = Phase::certify_build;
  } else {
    phase_ = Phase::done;
  }
  return static_cast<std::uint32_t>(ray_units::started(std::uint64_t{positions} * all_rays_));
}

}  // namespace sortie::planner
