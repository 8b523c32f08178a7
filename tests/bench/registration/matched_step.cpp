// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/matched_step.hpp"

#include "mapping/registration/match_covariance.hpp"

namespace sortie::bench {
MatchedStep matched_step(OwnedRegistration& map, const std::vector<rt::ScanPoint>& scan,
                         const mapping::RigidPose& start, double usual_share) {
  MatchedStep step;
  const mapping::PosePrior prior = loose_prior(start);
  const double begin = step_cpu_ms();
  mapping::ScanRegistration& registration = map.registration;
  (void)registration.take(scan);
  step.match = registration.match(start, start, prior, usual_share);
  step.has_covariance = mapping::match_covariance(step.match.equations, step.match.weak, prior,
                                                  step.match.spread, step.covariance);
  step.crossed =
      mapping::rays_through_surfaces(registration.layer(0), registration.sample(), step.match.pose, 128, 64) /
      128.0;
  step.ms = step_cpu_ms() - begin;
  return step;
}

}  // namespace sortie::bench
