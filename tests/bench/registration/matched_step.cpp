// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/matched_step.hpp"

#include "mapping/registration/match_covariance.hpp"
#include "tests/bench/report/front.hpp"

namespace sortie::bench {
MatchedStep matched_step(OwnedRegistration& map, const std::vector<rt::ScanPoint>& scan,
                         const mapping::RigidPose& start, Known known) {
  MatchedStep step;
  const mapping::PosePrior prior = loose_prior(start, known);
  const double begin = step_cpu_ms();
  mapping::ScanRegistration& registration = map.registration;
  (void)registration.take(scan);
  step.match = registration.match(start, start, prior, 0.0);
  step.has_covariance = mapping::match_covariance(step.match.equations, step.match.weak, prior,
                                                  step.match.spread, step.covariance);
  step.crossed =
      mapping::rays_through_surfaces(registration.layer(0), registration.sample(), step.match.pose, 128, 64) /
      128.0;
  step.ms = step_cpu_ms() - begin;
  return step;
}

void MatchedSteps::add(const MatchedStep& step, const mapping::RigidPose& truth) {
  const PoseError error = pose_error(step.match.pose, truth);
  ms.add(step.ms);
  mm.add(1e3 * error.move_m);
  deg.add(error.turn_deg);
  right += error.within(0.02, 0.2) ? 1 : 0;
  weak += step.match.weak.moves + step.match.weak.turns > 0 ? 1 : 0;
}

std::vector<std::string> MatchedSteps::columns() const {
  return {
      decimals(ms.median(), 2),        decimals(ms.quantile(0.99), 2),
      decimals(mm.median(), 2),        decimals(mm.quantile(0.95), 1),
      decimals(deg.quantile(0.95), 3), decimals(100.0 * right / static_cast<double>(ms.size()), 1) + " %"};
}

MatchedSteps matched_steps(const mapping::RegistrationConfig& config, const std::vector<MapAndScans>& sets) {
  MatchedSteps steps;
  for (const MapAndScans& set : sets) {
    const auto map = map_of(set, config);
    for (std::size_t i = 0; i < set.scans.size(); ++i)
      steps.add(matched_step(*map, set.scans[i].points, set.starts[i], Known::odometry), set.scans[i].pose);
  }
  return steps;
}

}  // namespace sortie::bench
