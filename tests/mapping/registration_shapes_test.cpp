// SPDX-License-Identifier: BSD-3-Clause
// Shapes that slide along themselves: matching names the directions, and its covariance is no smaller than
// its errors.
#include <catch2/catch.hpp>

#include "tests/mapping/shape_trials.hpp"

TEST_CASE("What a shape leaves free is named, and what it holds is not", "[heavy]") {
  using namespace sortie::testing;
  constexpr std::uint64_t kSeed = 20'000;
  constexpr int kTrials = 40;
  for (const ShapeKind kind : kShapeKinds) {
    ShapeTally tally;
    for (int i = 0; i < kTrials; ++i) try_shape(kind, kSeed + static_cast<std::uint64_t>(i), tally);
    CAPTURE(name_of(kind), kSeed, tally.moves.named, tally.moves.real, tally.turns.named, tally.turns.real);
    CHECK(tally.moves.recall() >= 0.97);
    CHECK(tally.turns.recall() >= 0.97);
    CHECK(tally.moves.precision() >= 0.95);
    CHECK(tally.turns.named - tally.turns.named_right <= 1);
    CHECK(tally.refused == 0);
    CHECK(tally.nees / (6 * kTrials) < 1.5);
  }
}
