// SPDX-License-Identifier: BSD-3-Clause
// The judge of partitions in `sortie bench mapping`, by hand and beside a count over all pairs.
#include <catch2/catch.hpp>

#include "tests/bench/mapping/rand_index.hpp"
#include "tests/mapping/random_worlds.hpp"

namespace sortie {
namespace {

// From the counts of pairs that both, either or none of the partitions join.
double rand_by_pairs(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  double both = 0;
  double only_a = 0;
  double only_b = 0;
  double none = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool in_a = a[i] == a[j];
      const bool in_b = b[i] == b[j];
      (in_a && in_b ? both : in_a ? only_a : in_b ? only_b : none) += 1;
    }
  }
  const double denominator = (both + only_a) * (only_a + none) + (both + only_b) * (only_b + none);
  return denominator > 0 ? 2 * (both * none - only_a * only_b) / denominator : 1;
}

}  // namespace

TEST_CASE("Agreement of partitions is 1 for equal ones, 0 for chance, and that of all pairs in between") {
  using bench::adjusted_rand_index;
  CHECK(adjusted_rand_index({1, 1, 2, 2}, {7, 7, 3, 3}) == 1.0);
  CHECK(adjusted_rand_index({1, 1, 1, 1}, {1, 2, 3, 4}) == 0.0);
  CHECK(adjusted_rand_index({1, 1, 2, 2}, {1, 2, 1, 2}) == Approx(-0.5));
  CHECK(adjusted_rand_index({}, {}) == 1.0);
  const std::uint32_t seed = 20;
  INFO("seed " << seed);
  tests::WorldRandom random(seed);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<std::uint32_t> a(2 + random.below(30));
    std::vector<std::uint32_t> b(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      a[i] = random.below(5);
      b[i] = random.below(3) == 0 ? random.below(5) : a[i];
    }
    CHECK(adjusted_rand_index(a, b) == Approx(rand_by_pairs(a, b)).margin(1e-12));
  }
}

}  // namespace sortie
