// SPDX-License-Identifier: BSD-3-Clause
// A scan matched and judged as the locator does it, against a map that stays as it is.
#pragma once

#include "tests/bench/registration/hall_case.hpp"

namespace sortie::bench {

/// What became of a scan.
struct JudgedMatch {
  mapping::Match match;
  double crossed{};  ///< of the rays
  bool has_covariance{};
  double covariance[6][6]{};
  mapping::LocateVerdict verdict{};
  double ms{};  ///< of the thread, from the returns to the covariance and the verdict
};

/// The locator's step without its map's growth. `usual_share`: of the scan before; 0: there was none.
JudgedMatch judged_match(OwnedRegistration& map, const mapping::RegistrationConfig& config,
                         const std::vector<rt::ScanPoint>& scan, const mapping::RigidPose& start,
                         double usual_share);

}  // namespace sortie::bench
