// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/judged_match.hpp"

#include "mapping/registration/match_covariance.hpp"

namespace sortie::bench {
namespace {

mapping::LocateVerdict verdict_of(const mapping::RegistrationConfig& config, const JudgedMatch& judged,
                                  double usual_share) {
  const mapping::Match& match = judged.match;
  if (match.equations.rows < 6) return mapping::LocateVerdict::unheld;
  if (match.score.matched < config.least_share * match.score.known ||
      match.score.known < config.least_known || match.score.matched < 0.7 * usual_share)
    return mapping::LocateVerdict::little_share;
  if (judged.crossed > config.most_crossed) return mapping::LocateVerdict::crossed;
  if (match.ambiguous) return mapping::LocateVerdict::ambiguous;
  return mapping::LocateVerdict::accepted;
}

}  // namespace

JudgedMatch judged_match(OwnedRegistration& map, const mapping::RegistrationConfig& config,
                         const std::vector<rt::ScanPoint>& scan, const mapping::RigidPose& start,
                         double usual_share) {
  JudgedMatch judged;
  const mapping::PosePrior prior = loose_prior(start);
  const double begin = step_cpu_ms();
  mapping::ScanRegistration& registration = map.registration;
  (void)registration.take(scan);
  judged.match = registration.match(start, start, prior, usual_share);
  judged.has_covariance = mapping::match_covariance(judged.match.equations, judged.match.weak, prior,
                                                    judged.match.spread, judged.covariance);
  judged.crossed = mapping::rays_through_surfaces(registration.layer(0), registration.sample(),
                                                  judged.match.pose, 128, 64) /
                   128.0;
  judged.verdict = verdict_of(config, judged, usual_share);
  judged.ms = step_cpu_ms() - begin;
  return judged;
}

}  // namespace sortie::bench
