// SPDX-License-Identifier: BSD-3-Clause
// What is usual on a core that is flooded now and then.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "rt/posix/delay_evidence.hpp"

namespace sortie::rt::posix {
namespace {

// The obvious way: a mean that follows slowly and takes a flood for twice the usual at most.
struct SlowMean {
  double per_s{};
  void take(double rate) {
    per_s = per_s == 0.0 ? rate : per_s + (std::min(rate, 2.0 * per_s + 50.0) - per_s) / 32.0;
  }
};

}  // namespace

TEST_CASE("a flood in every third window is not usual, where a slow mean takes it for that") {
  for (const double base : {100.0, 1'300.0, 20'000.0}) {
    INFO("base " << base);
    UsualRate usual;
    SlowMean mean;
    std::mt19937 random(7);
    for (int window = 0; window < 6'000; ++window) {
      const double noise = 0.9 + 0.2 * static_cast<double>(random()) / 4294967296.0;
      const double rate = noise * (window % 3 == 2 ? 60.0 * base : base);
      usual.take(rate);
      mean.take(rate);
      if (window < 1'000) continue;
      CHECK(usual.per_s() > 0.8 * base - 10.0);
      CHECK(usual.per_s() < 1.3 * base + 10.0);
    }
    CHECK(mean.per_s > 1.5 * base);
  }
}

TEST_CASE("what lasts becomes usual within some seconds, and the first window may be a flood") {
  UsualRate usual;
  usual.take(1e6);
  CHECK(usual.per_s() < 2'200.0);
  for (int window = 0; window < 300; ++window) usual.take(1'000.0);
  CHECK(usual.per_s() == Approx(1'000.0).epsilon(0.1));
  for (int window = 0; window < 300; ++window) usual.take(20'000.0);
  CHECK(usual.per_s() == Approx(20'000.0).epsilon(0.1));
  for (int window = 0; window < 1'000; ++window) usual.take(0.0);
  CHECK(usual.per_s() < 50.0);
  CHECK(usual.per_s() > 0.0);
}

}  // namespace sortie::rt::posix
