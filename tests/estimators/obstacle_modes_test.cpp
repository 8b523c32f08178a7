// SPDX-License-Identifier: BSD-3-Clause
// Modes over a step that is climbed by closed-form geometry; mirror images; noise; planes.
#include "estimators/obstacle_modes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/estimators/obstacle_drive.hpp"

namespace {

using sortie::estimators::FlipperAngles;
using sortie::estimators::ObstacleMode;
using sortie::estimators::ObstacleModes;
using sortie::estimators::ObstacleModesConfig;
using sortie::estimators::ObstacleMotion;
using sortie::estimators::ObstacleStep;
using sortie::estimators::PivotIdea;
using sortie::estimators::test::climb_step;
using sortie::estimators::test::ClimbStep;

constexpr FlipperAngles kFolded{2.7, 2.7};

double rise(const ObstacleStep& step, const sortie::rt::Vector3& moved) {
  const sortie::rt::Vector3 up = 0.5 * (step.up_begin + step.up_end);
  return dot(moved, up) / norm(up);
}

/// Root of the mean square of what is missed along the way.
struct ClimbErrors {
  double ours{}, standard{}, end_m{};
};

ClimbErrors over_step(ObstacleModes& modes, const std::vector<ClimbStep>& climb) {
  ClimbErrors e;
  double ours = climb.front().height_m, standard = ours;
  for (ClimbStep c : climb) {
    c.step.flippers = kFolded;
    ours += rise(c.step, modes.update(c.step).step_body_m);
    standard += rise(c.step, {c.step.travel_m, 0, 0});
    e.ours += (ours - c.height_m) * (ours - c.height_m) / static_cast<double>(climb.size());
    e.standard += (standard - c.height_m) * (standard - c.height_m) / static_cast<double>(climb.size());
    e.end_m = ours - c.height_m;
  }
  e.ours = std::sqrt(e.ours);
  e.standard = std::sqrt(e.standard);
  return e;
}

/// The same step of a robot that is its own mirror image, front to rear or left to right.
ObstacleStep reversed(ObstacleStep s) {
  s.travel_m = -s.travel_m;
  s.turn_rad = {-s.turn_rad.x, -s.turn_rad.y, s.turn_rad.z};
  s.up_begin = {-s.up_begin.x, -s.up_begin.y, s.up_begin.z};
  s.up_end = {-s.up_end.x, -s.up_end.y, s.up_end.z};
  std::swap(s.flippers.front_rad, s.flippers.rear_rad);
  return s;
}
ObstacleStep mirrored(ObstacleStep s) {
  s.turn_rad = {-s.turn_rad.x, s.turn_rad.y, -s.turn_rad.z};
  s.up_begin.y = -s.up_begin.y;
  s.up_end.y = -s.up_end.y;
  return s;
}

}  // namespace

TEST_CASE("While the rear wheel rolls and an edge carries the run, low rear is the closed form") {
  for (const double height : {0.04, 0.06, 0.09}) {
    ObstacleModesConfig config;
    config.creep_m_s = 0.0;
    config.window_m = 0.001;  // what smoothing costs is not the question here
    ObstacleModes modes(config);
    double z = 0, truth = 0, leant_m = 0;
    double before = -config.profile.run_m();
    for (ClimbStep c : climb_step(config.profile, height, 0.15, 0.005)) {
      c.step.flippers = kFolded;
      static_cast<void>(modes.update(c.step));
      leant_m += c.leans ? c.step.travel_m : 0.0;
      if (c.leans && leant_m > 0.05) {  // the smoothed curvature has forgotten the face of the step
        // Along the body the rear wheel's contact does not slip.
        const double d = std::asin(c.step.up_end.x);
        const sortie::estimators::Support rear =
            support_of(config.profile, sortie::estimators::OutlineEnd::rear, d, kFolded);
        const double along = c.step.travel_m * std::cos(d) - c.step.turn_rad.y * rear.z_m;
        z += rise(c.step, {along, 0, modes.normal_of(PivotIdea::rear_carries)});
        truth += c.height_m - before;
      }
      before = c.height_m;
    }
    INFO("step of " << height << " m: " << z << " for " << truth);
    CHECK(truth > 0.03);
    CHECK(z == Approx(truth).epsilon(0.01));
    CHECK(modes.state().step_height_m == Approx(height).epsilon(0.15));
  }
}

TEST_CASE("Over a step by geometry the height is nearer than v sin(pitch), at every speed") {
  for (const double speed : {0.05, 0.15, 0.5}) {
    for (const double height : {0.04, 0.06}) {
      ObstacleModes modes{ObstacleModesConfig{}};
      const ClimbErrors e = over_step(modes, climb_step({}, height, speed, 0.01));
      INFO("speed " << speed << " height " << height << ": " << 1e3 * e.ours << " mm, standard "
                    << 1e3 * e.standard);
      CHECK(e.standard > 0.004);
      CHECK(e.ours < e.standard);
    }
  }
}

TEST_CASE("The climb is named: low rear, then edge pivot, then planar") {
  ObstacleModes modes{ObstacleModesConfig{}};
  std::vector<std::uint32_t> names;
  for (ClimbStep c : climb_step({}, 0.06, 0.15, 0.01)) {
    c.step.flippers = kFolded;
    static_cast<void>(modes.update(c.step));
    if (names.empty() || names.back() != modes.state().mode) names.push_back(modes.state().mode);
  }
  const std::vector<std::uint32_t> expected{0, 1, 2, 0};
  CHECK(names == expected);
  CHECK(modes.state().step_height_m == Approx(0.06).epsilon(0.15));
}

TEST_CASE("A robot that backs up, and one seen in a mirror, do the same") {
  ObstacleModesConfig config;
  ObstacleModesConfig turned = config;
  turned.profile.com_x_m = -config.profile.com_x_m;
  ObstacleModes forward(config), backward(turned), mirror(config);
  const unsigned seed = 77;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (ClimbStep c : climb_step(config.profile, 0.06, 0.15, 0.01)) {
    c.step.flippers = {2.7, 0.4};
    c.step.turn_rad.x = 1e-3 * (static_cast<double>(random()) / 4294967296.0 - 0.3);
    c.step.up_end.y = c.step.up_begin.y = 0.1;
    const ObstacleMotion a = forward.update(c.step);
    const ObstacleMotion b = backward.update(reversed(c.step));
    const ObstacleMotion m = mirror.update(mirrored(c.step));
    REQUIRE(b.step_body_m.x == Approx(-a.step_body_m.x).margin(1e-12));
    REQUIRE(b.step_body_m.z == Approx(a.step_body_m.z).margin(1e-12));
    REQUIRE(m.step_body_m.x == Approx(a.step_body_m.x).margin(1e-12));
    REQUIRE(m.step_body_m.z == Approx(a.step_body_m.z).margin(1e-12));
    // Every idea and every feature is a mirror image, whichever of them the trees take here.
    for (std::uint8_t k = 0; k < sortie::estimators::kPivotIdeas; ++k) {
      INFO("idea " << int{k});
      REQUIRE(backward.normal_of(static_cast<PivotIdea>(k)) ==
              Approx(forward.normal_of(static_cast<PivotIdea>(k))).margin(1e-12));
    }
    for (std::uint32_t k = 0; k < sortie::estimators::kModeFeatures; ++k) {
      INFO("feature " << k);
      REQUIRE(backward.features()[k] == Approx(forward.features()[k]).margin(1e-9));
      REQUIRE(mirror.features()[k] == Approx(forward.features()[k]).margin(1e-9));
    }
    // Front and rear change their names.
    const std::uint32_t name = forward.state().mode;
    REQUIRE(backward.state().mode == (name == 1 ? 3u : name == 3 ? 1u : name));
  }
}

TEST_CASE("Until a robot's length has passed, the way since the plane tells a bridge from a ramp") {
  // Nose up within 10 cm, then steady: the features know how far the plane is behind.
  ObstacleModes modes{ObstacleModesConfig{}};
  const auto feature = [&](sortie::estimators::ModeFeature f) {
    return modes.features()[static_cast<std::uint32_t>(f)];
  };
  const auto drive = [&](double way, double from, double to) {
    for (int i = 0; i < 100; ++i) {
      const double a = from + (to - from) * i / 100.0, b = from + (to - from) * (i + 1) / 100.0;
      static_cast<void>(modes.update(sortie::estimators::test::level_step(0.01, way / 100.0, a, b)));
    }
  };
  drive(0.5, 0.0, 0.0);
  CHECK(feature(sortie::estimators::ModeFeature::away) == 0.0);
  drive(0.1, 0.0, 0.2);
  drive(0.1, 0.2, 0.2);
  // The smoothed curvature needs its window to begin and to end a rise.
  CHECK(feature(sortie::estimators::ModeFeature::away) == Approx(0.2).margin(0.005));
  CHECK(feature(sortie::estimators::ModeFeature::rise_ago) == Approx(0.2).margin(0.005));
  CHECK(feature(sortie::estimators::ModeFeature::fall_ago) == 1.0);
  CHECK(feature(sortie::estimators::ModeFeature::last_turn) == Approx(0.2).margin(0.01));
  CHECK(feature(sortie::estimators::ModeFeature::base_tilt) == Approx(0.2).margin(1e-9));
  drive(0.3, 0.2, 0.2);
  CHECK(feature(sortie::estimators::ModeFeature::away) == 0.0);
}

TEST_CASE("On planes there is one mode, however steep, and noise of the attitude adds no height") {
  const unsigned seed = 4;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (const double pitch : {0.0, 0.3, -0.5}) {
    for (const double speed : {0.05, 0.5, -0.2}) {
      ObstacleModes modes{ObstacleModesConfig{}};
      double lost = 0;
      double now = pitch;
      for (int i = 0; i < 3000; ++i) {
        const double next =
            pitch + 0.999 * (now - pitch) + 5e-5 * (static_cast<double>(random()) / 2147483648.0 - 1);
        ObstacleStep s = sortie::estimators::test::level_step(0.01, 0.01 * speed, now, next);
        s.turn_rad.x = 5e-5 * (static_cast<double>(random()) / 2147483648.0 - 1);
        s.turn_rad.z = 0.003;  // it turns on the spot, too
        const ObstacleMotion motion = modes.update(s);
        lost += motion.step_body_m.z;
        REQUIRE(modes.state().mode == static_cast<std::uint32_t>(ObstacleMode::planar));
        now = next;
      }
      CHECK(std::fabs(lost) < 1e-4);
    }
  }
}

TEST_CASE("Belts and body at rest are stationary, and a creeping belt loses nothing") {
  ObstacleModes modes{ObstacleModesConfig{}};
  double way = 0;
  for (int i = 0; i < 100; ++i)
    way += modes.update(sortie::estimators::test::level_step(0.01, 1e-5, 0.2, 0.2)).step_body_m.x;
  CHECK(modes.state().mode == static_cast<std::uint32_t>(ObstacleMode::stationary));
  CHECK(way == Approx(1e-3));
}

TEST_CASE("The trees are trees: every way down ends in a leaf, ideas exist") {
  // Any features, also wild ones: decide() stops after its depth, and what it gives is finite.
  const unsigned seed = 12;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  ObstacleModes modes{ObstacleModesConfig{}};
  double pitch = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto uniform = [&](double most) {
      return most * (static_cast<double>(random()) / 2147483648.0 - 1);
    };
    const double travel = uniform(0.02);
    const double next = std::max(-1.4, std::min(1.4, pitch + uniform(0.1)));
    ObstacleStep s = sortie::estimators::test::level_step(0.01, travel, pitch, next);
    s.turn_rad.x = uniform(0.1);
    s.flippers = {uniform(3), uniform(3)};
    const ObstacleMotion m = modes.update(s);
    REQUIRE(std::isfinite(m.sigma_m));
    REQUIRE(norm(m.step_body_m) < 0.2);
    REQUIRE(modes.state().confidence >= 0.0);
    REQUIRE(modes.state().confidence <= 1.0);
    pitch = next;
  }
}
