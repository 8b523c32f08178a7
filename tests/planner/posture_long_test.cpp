// SPDX-License-Identifier: BSD-3-Clause
// Postures beside the plant, and bounds beside drawn grounds: minutes.
#include "tests/planner/posture_bounds_trial.hpp"
#include "tests/planner/posture_judge_rests.hpp"

namespace sortie::planner {

TEST_CASE("postures are those that the plant comes to rest in, ten thousand of them", "[long]") {
  judge_rests(100'001, 2'000);
}

TEST_CASE("no ground within the bounds of its cells rests outside of the posture's, many of them", "[long]") {
  BoundsTally tally;
  for (std::uint64_t seed = 1001; seed <= 1600; ++seed)
    try_bounds(seed, 0.15 * static_cast<double>(seed % 7), 0.02 * static_cast<double>(1 + seed % 6), 30,
               tally);
  std::printf(
      "seeds 1001..1600: %d samples, %d outside, %d tip or steeper, %d not settled; %d of %d may tip\n",
      tally.samples, tally.outside, tally.tips, tally.unsettled, tally.may_tip, tally.cases);
}

}  // namespace sortie::planner
