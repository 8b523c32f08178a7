// SPDX-License-Identifier: BSD-3-Clause
// Steps of registration against a map that stays as it is.
#pragma once

#include <string>

#include "tests/bench/registration/scan_sets.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// What became of a scan.
struct MatchedStep {
  mapping::Match match;
  double crossed{};  ///< of the rays
  bool has_covariance{};
  double covariance[6][6]{};
  double ms{};  ///< of the thread, from the returns to the covariance, and along the rays
};

/// The locator's step without its map's growth; there was no scan before.
MatchedStep matched_step(OwnedRegistration& map, const std::vector<rt::ScanPoint>& scan,
                         const mapping::RigidPose& start, Known known);

/// Many of them.
struct MatchedSteps {
  Rounds ms, mm, deg;
  int right{};  ///< within 2 cm and 0.2 degrees
  int weak{};   ///< with a direction that the scan does not hold

  void add(const MatchedStep& step, const mapping::RigidPose& truth);
  static constexpr const char* kColumns[] = {"ms median", "p99",      "mm median",
                                             "mm 95 %",   "deg 95 %", "within 2 cm, 0.2 deg"};
  /// As kColumns.
  std::vector<std::string> columns() const;
};

/// Each scan of each set, on its set's map, with odometry.
MatchedSteps matched_steps(const mapping::RegistrationConfig& config, const std::vector<MapAndScans>& sets);

}  // namespace sortie::bench
