// SPDX-License-Identifier: BSD-3-Clause
// The trials of the tracked plant in numbers: a thousand drops, a million steps under extremes, all proving
// drives.
#include "plant_proofs.hpp"
#include "plant_trials.hpp"

using namespace sortie::hil;

TEST_CASE("plant: a thousand drops never gain energy", "[plant][long]") {
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    CAPTURE(seed);
    CHECK(gain_of_drop(seed) <= 1e-9);
  }
}

TEST_CASE("plant: a million random steps stay finite", "[plant][long]") {
  constexpr std::uint64_t kSeed = 77;
  CAPTURE(kSeed);
  const Shaken shaken = shake(kSeed, 1'000'000);
  CHECK(shaken.first_not_finite == -1);
  CHECK(shaken.wrong == 0);
  CHECK(shaken.rejected <= 10);
}

TEST_CASE("plant: every drive that is not marginal agrees with the dense solver, its image and 5 ms",
          "[plant][long]") {
  int judged = 0;
  for (const ProvingDrive& drive : proving_drives()) {
    for (const ContactMode mode : {ContactMode::csm, ContactMode::belt}) {
      const ProvingWay way{1e-3, mode};
      if (is_marginal(drive, way)) {
        WARN(drive.name << " is marginal in mode " << static_cast<int>(mode));
        continue;
      }
      prove_mirror_image(drive, way);
      CAPTURE(drive.name, static_cast<int>(mode));
      check(prove_against_dense(drive, way));
      CHECK(prove_step_size(drive, way) < 0.02);
      ++judged;
    }
  }
  CHECK(judged >= 10);  // of twelve: one drive may be marginal in both modes
}
