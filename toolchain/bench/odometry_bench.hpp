// SPDX-License-Identifier: BSD-3-Clause
// Error of attitude and odometry against what they cost: over rate, precision, and parts left out.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/scene/json.hpp"
#include "toolchain/bench/odometry_sets.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// One cell: a variant on a set at a rate.
struct OdometryCell {
  std::string set;
  std::string variant;
  double rate_hz{};
  double cost_us_per_s{};  ///< processor time of the thread per second of the robot's, fastest of all rounds
  std::map<std::string, double> errors;
  std::uint64_t slips{};  ///< steps that were called slip
  bool on_front{};        ///< no other cell of the set is as cheap (within 5 %) and better (by 0.1 %)
  bool profile_choice{};  ///< what the scene says by itself
};

/// The variants. The first is everything, in double; each other one leaves one part out.
inline constexpr const char* kOdometryVariants[] = {"all, double",      "all, float",   "no bias filter",
                                                    "no coning",        "no track aid", "no obstacle modes",
                                                    "no turning centre"};

/// Measures every variant that changes something on `set`, at its own rate and at those of `every` (each the
/// set thinned so much), `rounds` times by turns.
std::vector<OdometryCell> measure_odometry(const OdometrySet& set, const std::vector<std::uint32_t>& every,
                                           int rounds);

/// Runs one variant once: the trajectory it makes, without any timing. For tests.
firmware::Trajectory run_odometry_variant(const OdometrySet& set, const std::string& variant);

/// Error over cost of one set's cells, with the Pareto front and the profile's choice.
Plot plot_odometry(const OdometrySet& set, const std::vector<OdometryCell>& cells);

/// Height along the way of a set with true heights: truth, the odometry with everything, and the plain
/// method, at the rate of the scene's own sensor.
Plot plot_heights(const OdometrySet& set);

/// A table of the cells in text, in Markdown.
void print_odometry(std::ostream& out, const OdometrySet& set, const std::vector<OdometryCell>& cells);
std::string odometry_table(const OdometrySet& set, const std::vector<OdometryCell>& cells);

/// The cells as rows of JSON.
firmware::Json to_json(const std::vector<OdometryCell>& cells);

}  // namespace sortie::toolchain
