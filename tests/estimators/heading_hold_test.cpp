// SPDX-License-Identifier: BSD-3-Clause
// What a rest is worth to the heading.
#include <catch2/catch.hpp>
#include <cmath>

#include "estimators/heading_hold.hpp"

using namespace sortie;
using estimators::AttitudeConfig;
using estimators::HeadingBlock;
using estimators::HeadingHold;

namespace {

constexpr double kBlock_s = 0.035;

/// Share of a lesson of 0.01 rad that is owed after a rest of `rest_s`, behind a drive of `drive_s` that
/// began with a bias well known. Its looks scatter by `noise` times what the settings say.
double share(double drive_s, double rest_s, double noise) {
  const AttitudeConfig config;
  HeadingHold<double> hold(config.bias_sigma_initial_rad_s * config.bias_sigma_initial_rad_s);
  const auto rest = [&](double lasts_s, double lesson, double times) {
    const double scatter = times * config.gyr_noise_rad_s_rthz / std::sqrt(kBlock_s);
    const int looks = static_cast<int>(lasts_s / kBlock_s);
    for (int i = 0; i < looks; ++i) {
      hold.learn(lesson / looks, i % 2 == 0 ? scatter : -scatter, kBlock_s);
      CHECK(hold.close(config, HeadingBlock::rests, 0.0, kBlock_s).now == 0.0);
    }
  };
  rest(60, 0.0, 1.0);
  for (int i = 0; i < static_cast<int>(drive_s / kBlock_s); ++i)
    static_cast<void>(hold.close(config, HeadingBlock::moves, 0.0, kBlock_s));
  rest(rest_s, 0.01, noise);
  static_cast<void>(hold.close(config, HeadingBlock::quiet, 0.0, kBlock_s));
  return hold.owed() / 0.01;
}

}  // namespace

TEST_CASE("A lesson counts by the drift since the last rest against the noise of its looks") {
  const double density = 2 * AttitudeConfig{}.gyr_noise_rad_s_rthz * AttitudeConfig{}.gyr_noise_rad_s_rthz;
  for (const double drive_s : {10.0, 40.0, 160.0}) {
    for (const double rest_s : {0.5, 2.0, 10.0}) {
      // Looks that jump from +s to -s have twice the square of white ones: read off as 2 r.
      const double walk = AttitudeConfig{}.bias_walk_rad_s_rts;
      const double drift = density / 18 + walk * walk * drive_s;
      INFO("drive " << drive_s << " s, rest " << rest_s << " s");
      CHECK(share(drive_s, rest_s, 1.0) == Approx(drift * rest_s / (drift * rest_s + density)).epsilon(0.1));
    }
  }
  CHECK(share(40, 0.5, 1.0) < 0.2);
  CHECK(share(160, 60, 1.0) > 0.9);
  CHECK(share(40, 2, 3.0) < 0.5 * share(40, 2, 1.0));
}

TEST_CASE("A robot that rests does not turn, and what was withheld while it was doubted is not owed") {
  const AttitudeConfig config;
  HeadingHold<double> hold(1e-6);
  for (int i = 0; i < 5; ++i) CHECK(hold.close(config, HeadingBlock::stands, 1e-4, kBlock_s).now == -1e-4);
  CHECK(hold.doubted_s() == Approx(5 * kBlock_s));
  CHECK(hold.close(config, HeadingBlock::rests, 2e-4, kBlock_s).now == -2e-4);
  CHECK(hold.doubted_s() == 0.0);
  static_cast<void>(hold.close(config, HeadingBlock::moves, 0.0, kBlock_s));
  CHECK(hold.owed() == 0.0);
}

TEST_CASE(
    "What was withheld and turned out to be motion is paid in motion, no faster than it may be, and whole") {
  const AttitudeConfig config;
  const double most = config.heading_payment_rad_s * kBlock_s;
  for (const double turned : {0.4 * most, -3.3 * most}) {
    HeadingHold<double> hold(1e-6);
    CHECK(hold.close(config, HeadingBlock::stands, turned, kBlock_s).now == -turned);
    CHECK(hold.close(config, HeadingBlock::quiet, 0.0, kBlock_s).now == 0.0);
    CHECK(hold.owed() == turned);
    double paid = 0;
    for (int i = 0; i < 6; ++i) {
      const double now = hold.close(config, HeadingBlock::moves, 0.0, kBlock_s).now;
      CHECK(std::fabs(now) <= most);
      paid += now;
    }
    CHECK(paid == Approx(turned));
    CHECK(hold.owed() == Approx(0.0).margin(1e-15));
  }
}
