// SPDX-License-Identifier: BSD-3-Clause
// Speed and turn rate together: curvature, belts, and every limit at every step.
#include "planner/twist_limiter.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planner/icr_model.hpp"

namespace {
using namespace sortie::planner;

TwistLimits limits_of(const IcrModel& model) { return {0.5, 1.2, 0.6, model.lever_m()}; }
}  // namespace

TEST_CASE("What does not fit is shortened without changing the curvature, and what fits is not touched") {
  std::mt19937_64 random(4);
  const auto draw = [&random](double most) {
    return most * (static_cast<double>(random() >> 11) * 0x1p-52 - 1.0);
  };
  for (int i = 0; i < 20'000; ++i) {
    const IcrModel model{0.0, 0.1 + std::fabs(draw(0.6)), -0.1 - std::fabs(draw(0.6))};
    const TwistLimits limits = limits_of(model);
    const SpeedTurn wish{draw(1.5), draw(4.0)};
    const SpeedTurn fitted = fit(wish, limits);
    const TrackSpeeds tracks = model.to_tracks(fitted.speed_m_s, fitted.turn_rad_s);
    REQUIRE(std::fabs(tracks.left_m_s) <= limits.max_track_m_s * (1 + 1e-12));
    REQUIRE(std::fabs(tracks.right_m_s) <= limits.max_track_m_s * (1 + 1e-12));
    REQUIRE(std::fabs(fitted.speed_m_s) <= limits.max_speed_m_s * (1 + 1e-12));
    REQUIRE(std::fabs(fitted.turn_rad_s) <= limits.max_turn_rad_s * (1 + 1e-12));
    // w / v as asked for; written without a division.
    REQUIRE(fitted.turn_rad_s * wish.speed_m_s == Approx(wish.turn_rad_s * fitted.speed_m_s).margin(1e-14));
    const double belt = std::fabs(wish.speed_m_s) + limits.lever_m * std::fabs(wish.turn_rad_s);
    const bool fits = belt <= limits.max_track_m_s && std::fabs(wish.speed_m_s) <= limits.max_speed_m_s &&
                      std::fabs(wish.turn_rad_s) <= limits.max_turn_rad_s;
    if (fits) {
      REQUIRE(fitted.speed_m_s == wish.speed_m_s);
      REQUIRE(fitted.turn_rad_s == wish.turn_rad_s);
    } else {  // one limit is used up
      REQUIRE(std::max({(std::fabs(fitted.speed_m_s) + limits.lever_m * std::fabs(fitted.turn_rad_s)) /
                            limits.max_track_m_s,
                        std::fabs(fitted.speed_m_s) / limits.max_speed_m_s,
                        std::fabs(fitted.turn_rad_s) / limits.max_turn_rad_s}) == Approx(1.0));
    }
  }
}

TEST_CASE("Random set-points: every limit of body and belts holds at every step, and each goal is reached") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    const auto draw = [&random](double low, double high) {
      return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    const IcrModel model = IcrModel::from_efficiency(0.4, draw(0.5, 1.0), 0.0, draw(-0.05, 0.05));
    const TwistLimits limits = limits_of(model);
    const TwistRamps ramps{{draw(0.2, 2.0), draw(1.0, 20.0)}, {draw(1.0, 6.0), draw(5.0, 60.0)}};
    const double dt = draw(0.001, 0.02);
    TwistLimiter limiter;
    TrackSpeeds tracks;
    for (int leg = 0; leg < 30; ++leg) {
      const SpeedTurn wish{random() % 6 == 0 ? 0.0 : draw(-1, 1), random() % 6 == 0 ? 0.0 : draw(-3, 3)};
      const SpeedTurn goal = fit(wish, limits);
      const bool to_the_end = random() % 3 == 0;
      const int steps = to_the_end ? static_cast<int>(10.0 / dt) : static_cast<int>(random() % 60);
      for (int i = 0; i < steps; ++i) {
        const TwistLimiter before = limiter;
        limiter.step(wish, limits, ramps, dt);
        const double v = limiter.now().speed_m_s;
        const double w = limiter.now().turn_rad_s;
        REQUIRE(std::fabs(v) <= limits.max_speed_m_s + 1e-9);
        REQUIRE(std::fabs(w) <= limits.max_turn_rad_s + 1e-9);
        REQUIRE(std::fabs(limiter.speed().rate) <= ramps.speed.acceleration * (1 + 1e-9));
        REQUIRE(std::fabs(limiter.turn().rate) <= ramps.turn.acceleration * (1 + 1e-9));
        REQUIRE(std::fabs(limiter.speed().rate - before.speed().rate) <= ramps.speed.jerk * dt * (1 + 1e-8));
        REQUIRE(std::fabs(limiter.turn().rate - before.turn().rate) <= ramps.turn.jerk * dt * (1 + 1e-8));
        tracks = model.to_tracks(v, w);
        REQUIRE(std::fabs(tracks.left_m_s) <= limits.max_track_m_s + 1e-8);
        REQUIRE(std::fabs(tracks.right_m_s) <= limits.max_track_m_s + 1e-8);
      }
      if (to_the_end) {
        REQUIRE(limiter.now().speed_m_s == Approx(goal.speed_m_s).margin(1e-9));
        REQUIRE(limiter.now().turn_rad_s == Approx(goal.turn_rad_s).margin(1e-9));
      }
    }
  }
}

TEST_CASE("From rest and to rest the curvature is the one asked for at every step") {
  const TwistLimits limits{0.5, 1.2, 0.6, 0.3};
  const TwistRamps ramps{{0.5, 5.0}, {2.0, 9.0}};
  for (const SpeedTurn wish : {SpeedTurn{0.4, 0.3}, {-0.2, 0.9}, {0.1, -1.1}, {3.0, 2.0}, {0.5, 0.01}}) {
    TwistLimiter limiter;
    double v_before = 0;
    int in_between = 0;
    for (int i = 0; i < 10'000; ++i) {
      const bool stops = i >= 5'000;
      limiter.step(stops ? SpeedTurn{} : wish, limits, ramps, 0.001);
      const SpeedTurn now = limiter.now();
      INFO("wish " << wish.speed_m_s << " " << wish.turn_rad_s << ", step " << i);
      REQUIRE(now.turn_rad_s * wish.speed_m_s == Approx(now.speed_m_s * wish.turn_rad_s).margin(1e-9));
      in_between += now.speed_m_s != v_before ? 1 : 0;
      v_before = now.speed_m_s;
    }
    CHECK(in_between > 400);  // there was something to keep
    CHECK(limiter.at_rest());
  }
}

TEST_CASE("Where both axes want the belts' whole speed, the one that has it gives way first") {
  const TwistLimits limits{0.6, 2.0, 0.6, 0.3};
  const TwistRamps ramps{{0.5, 5.0}, {3.0, 30.0}};
  TwistLimiter limiter;
  for (int i = 0; i < 5000; ++i) limiter.step({0.6, 0.0}, limits, ramps, 0.001);
  REQUIRE(limiter.now().speed_m_s == Approx(0.6));
  for (int i = 0; i < 5000; ++i) {
    limiter.step({0.0, 2.0}, limits, ramps, 0.001);
    REQUIRE(std::fabs(limiter.now().speed_m_s) + 0.3 * std::fabs(limiter.now().turn_rad_s) <= 0.6 + 1e-9);
  }
  CHECK(limiter.now().speed_m_s == 0.0);
  CHECK(limiter.now().turn_rad_s == 2.0);
}
