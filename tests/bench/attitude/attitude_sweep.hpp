// SPDX-License-Identifier: BSD-3-Clause
// Error against cost of the attitude filter: over rate, precision, and parts left out, beside VQF.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rt/rotation.hpp"
#include "rt/samples.hpp"

namespace sortie::bench {

/// A sample and the true attitude at its stamp.
struct JudgedSample {
  rt::ImuSample sample;
  rt::Quaternion truth;
  bool known{};   ///< there is a truth
  bool judged{};  ///< and it counts
};

/// A recording, or a simulation of one.
struct AttitudeSet {
  std::string name;
  double rate_hz{};
  std::vector<JudgedSample> samples;
};

/// One line: who, on what, how well, how dear.
struct AttitudeRow {
  std::string set;
  std::string variant;
  double rate_hz{};
  double inclination_deg{};  ///< RMSE
  double heading_deg{};      ///< RMSE, aligned at the first truth
  double ns{};               ///< of one update: the fastest of all rounds
};

/// The variants: double, float, no coning, no bias filter, ...; "VQF" is the peer.
inline constexpr const char* kAttitudeVariants[] = {"VQF",
                                                    "double",
                                                    "float",
                                                    "no coning",
                                                    "no bias filter",
                                                    "heading does not follow the bias",
                                                    "a block each sample"};

/// Two minutes of a robot that nods, turns and shakes: bias 0.3 deg/s, noise of a cheap sensor. Interval
/// means of 2 kHz. `rate_hz` divides 2000.
AttitudeSet simulate_attitude(std::uint32_t rate_hz);

/// Every `every`-th interval of `set`, its samples averaged: what a slower sensor would have sent.
AttitudeSet thinned(const AttitudeSet& set, std::uint32_t every);

/// All variants over one set, `rounds` times by turns, so that a slow minute of the machine meets all of
/// them.
std::vector<AttitudeRow> measure_attitude(const AttitudeSet& set, int rounds);

}  // namespace sortie::bench
