// SPDX-License-Identifier: BSD-3-Clause
// One step of registration against a map that stays as it is.
#pragma once

#include "tests/bench/registration/hall_case.hpp"

namespace sortie::bench {

/// What became of a scan.
struct MatchedStep {
  mapping::Match match;
  double crossed{};  ///< of the rays
  bool has_covariance{};
  double covariance[6][6]{};
  double ms{};  ///< of the thread, from the returns to the covariance, and along the rays
};

/// The locator's step without its map's growth. `usual_share`: of the scan before; 0: there was none.
MatchedStep matched_step(OwnedRegistration& map, const std::vector<rt::ScanPoint>& scan,
                         const mapping::RigidPose& start, double usual_share);

}  // namespace sortie::bench
