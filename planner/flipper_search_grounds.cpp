// SPDX-License-Identifier: BSD-3-Clause
// The best few choices on every ground that missing cells allow.
#include <algorithm>

#include "planner/flipper_search.hpp"

namespace sortie::planner {

void FlipperSearch::Points::note(int point, const FlipperWalk& walk, const FlipperWeights& weights) {
  cost[point] = walk.cost(weights);
  failed[point] = !walk.safe;
  near_failed[point] = !walk.near_safe;
}

JudgedFlippers FlipperSearch::sum(const Candidate& candidate, const Points& points) const {
  JudgedFlippers judged;
  judged.angles = candidate.angles;
  judged.margin_m = candidate.walk.margin_m;
  judged.clearance_m = candidate.walk.clearance_m;
  judged.pitch_rad = candidate.walk.pitch_rad;
  double share[MissingGround::kPoints];
  double failed[MissingGround::kPoints];
  double near_failed[MissingGround::kPoints];
  for (int k = 0; k < MissingGround::kPoints; ++k) {
    const int point = k < points_ ? k : 0;  // where nothing is missing all grounds are one
    share[k] = MissingGround::kShare[k] * points.cost[point];
    failed[k] = points.failed[point] ? MissingGround::kShare[k] : 0.0;
    near_failed[k] = points.near_failed[point] ? MissingGround::kShare[k] : 0.0;
  }
  // Points 3 and 4 are each other's mirror image, and added first.
  const auto total = [](const double(&v)[MissingGround::kPoints]) {
    return v[0] + v[1] + v[2] + (v[3] + v[4]) + v[5] + v[6] + v[7];
  };
  judged.cost = candidate.fixed_cost + total(share);
  judged.probability = open_ ? 1.0 : std::min(1.0, total(failed));
  judged.near_probability = near_open_ ? 1.0 : std::min(1.0, total(near_failed));
  return judged;
}

void FlipperSearch::judge_kept(FlipperFound& found) {
  Points kept[kKept];
  Points near[2];
  for (std::uint32_t k = 0; k < kept_.size(); ++k) kept[k].note(0, kept_[k].walk, config_.weights);
  for (std::uint32_t k = 0; k < near_.size(); ++k) near[k].note(0, near_[k].walk, config_.weights);
  for (int point = 1; point < points_; ++point) {
    rt::FixedVector<Candidate, kKept> walked = kept_;
    rt::FixedVector<Candidate, 2> near_walked = near_;
    for (Candidate& c : walked) c.walk = {.tilt = question_.tilt};
    for (Candidate& c : near_walked) c.walk = {.tilt = question_.tilt};
    for (int place = 0; place < kArcPlaces; ++place) {
      units_ += kLookUnits;
      // A look that fails leaves the ground before: taken for not safe, not for safe.
      const bool read = other_.look(ground_.view(point), places_[place]) == Status::ok;
      for (Candidate& c : walked) {
        (void)rest_at(other_, place, c);
        c.walk.safe = c.walk.safe && read;
        c.walk.near_safe = c.walk.near_safe && (read || place > 1);
      }
      if (place > 1) continue;
      for (Candidate& c : near_walked) {
        (void)rest_at(other_, place, c);
        c.walk.near_safe = c.walk.near_safe && read;
      }
    }
    for (std::uint32_t k = 0; k < walked.size(); ++k) kept[k].note(point, walked[k].walk, config_.weights);
    for (std::uint32_t k = 0; k < near_walked.size(); ++k)
      near[k].note(point, near_walked[k].walk, config_.weights);
  }
  const auto better = [this](double p, double cost, double than_p, double than_cost) {
    const bool safe = p <= config_.limit;
    const bool than_safe = than_p <= config_.limit;
    if (safe != than_safe) return safe;
    if (!safe && p != than_p) return p < than_p;
    return cost < than_cost;
  };
  for (std::uint32_t k = 0; k < kept_.size(); ++k) {
    const JudgedFlippers judged = sum(kept_[k], kept[k]);
    if (k == 0 || better(judged.probability, judged.cost, found.best.probability, found.best.cost))
      found.best = judged;
    if (k == 0 || better(judged.near_probability, judged.cost, found.near.near_probability, found.near.cost))
      found.near = judged;
  }
  found.stay = sum(near_[0], near[0]);
  found.feel = sum(near_[1], near[1]);
}

}  // namespace sortie::planner
