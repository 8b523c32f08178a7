// SPDX-License-Identifier: BSD-3-Clause
// The robot's outline against a twin that knows only circles: a flipper is the hull of two wheels, so a point
// is within `margin` of it when it is within `margin` of one of many wheels between the two.
#include "mapping/grid/self_filter.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace sortie::mapping {
namespace {

SelfFilterConfig absolem() {
  SelfFilterConfig config;
  config.boxes[0] = {{-0.122, 0, 0.118}, {0.25, 0.1205, 0.0695}};
  config.boxes[1] = {{0, 0.1985, 0.02}, {0.34, 0.049, 0.091}};
  config.boxes[2] = {{0, -0.1985, 0.02}, {0.34, 0.049, 0.091}};
  config.box_count = 3;
  config.flippers = {{0.25, 0.272, 0.0195}, 0.33, 0.089, 0.029, 0.0249};
  return config;
}

// Signed distance in the plane, from 2,000 wheels between the two: exact to 1e-7 m.
double flipper_distance_twin(const FlipperOutline& f, double along, double side) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 2000; ++i) {
    const double share = i / 2000.0;
    const double radius = f.large_radius_m + share * (f.small_radius_m - f.large_radius_m);
    nearest = std::min(nearest, std::hypot(along - share * f.length_m, side) - radius);
  }
  return nearest;
}

}  // namespace

TEST_CASE("self filter: a flipper is what two wheels and their tangents enclose") {
  const std::uint32_t seed = 5;
  CAPTURE(seed);
  std::mt19937 random(seed);
  const auto draw = [&random](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  SelfFilterConfig config = absolem();
  config.box_count = 0;
  SelfFilter filter(config);
  REQUIRE(filter.usable() == Status::ok);
  int inside = 0;
  for (int n = 0; n < 400; ++n) {
    const double angle[4] = {draw(-2, 2), draw(-2, 2), draw(-2, 2), draw(-2, 2)};
    REQUIRE(filter.set_flippers(angle) == Status::ok);
    const int flipper = static_cast<int>(random() % 4);
    const double ahead = flipper < 2 ? 1.0 : -1.0;
    const double pivot_x = ahead * config.flippers.pivot_m.x;
    const double pivot_y = (flipper % 2 == 0 ? 1.0 : -1.0) * config.flippers.pivot_m.y;
    const double along = draw(-0.2, 0.5);
    // Most points lie a tenth of a millimetre from the edge, where a wrong nearest part would show.
    double side = draw(0.0, 0.2);
    if (n % 4 != 0) {
      double low = 0.0;
      double high = 0.3;
      for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (flipper_distance_twin(config.flippers, along, middle) < config.margin_m ? low : high) = middle;
      }
      side = low + (n % 2 == 0 ? 1e-4 : -1e-4);
    }
    side *= n % 3 == 0 ? 1.0 : -1.0;
    const double expected = flipper_distance_twin(config.flippers, along, side);
    if (std::abs(expected - config.margin_m) < 1e-6) continue;
    const double c = std::cos(angle[flipper]);
    const double s = std::sin(angle[flipper]);
    const rt::Vector3 p{pivot_x + ahead * (along * c - side * s), pivot_y,
                        config.flippers.pivot_m.z + along * s + side * c};
    CAPTURE(n, flipper, along, side, expected);
    CHECK(filter.is_robot(p) == (expected <= config.margin_m));
    inside += expected <= config.margin_m ? 1 : 0;
    const double beside = config.flippers.half_width_m + config.margin_m + 1e-6;
    CHECK_FALSE(filter.is_robot({p.x, pivot_y + beside, p.z}));
    CHECK_FALSE(filter.is_robot({p.x, pivot_y - beside, p.z}));
  }
  CHECK(inside > 100);
}

TEST_CASE("self filter: boxes with their margin, and nothing beyond the robot's reach") {
  const SelfFilter filter(absolem());
  CHECK(filter.is_robot({-0.122, 0, 0.118}));
  CHECK(filter.is_robot({-0.122 + 0.279, 0, 0.118}));
  CHECK(filter.is_robot({0.33, 0.1985, 0.02}));
  CHECK_FALSE(filter.is_robot({-0.122, 0, 0.118 + 0.0695 + 0.031}));
  CHECK_FALSE(filter.is_robot({0, 0, 0.45}));
  CHECK_FALSE(filter.is_robot({25, 0, 0}));
}

TEST_CASE("self filter: an outline that is none is refused and nothing is taken for the robot") {
  const auto refused = [](auto change) {
    SelfFilterConfig config = absolem();
    change(config);
    const SelfFilter filter(config);
    return filter.usable() == Status::out_of_range && !filter.is_robot({-0.122, 0, 0.118});
  };
  CHECK(refused([](SelfFilterConfig& c) { c.box_count = 5; }));
  CHECK(refused([](SelfFilterConfig& c) { c.margin_m = -0.01; }));
  CHECK(refused([](SelfFilterConfig& c) { c.boxes[1].half_m.y = std::nan(""); }));
  CHECK(refused([](SelfFilterConfig& c) { c.flippers.large_radius_m = 0.5; }));  // holds the small wheel
  CHECK(refused([](SelfFilterConfig& c) { c.flippers.small_radius_m = 0.1; }));
  SelfFilter filter(absolem());
  const double bad[4] = {0, 0, std::nan(""), 0};
  CHECK(filter.set_flippers(bad) == Status::not_finite);
  CHECK(filter.is_robot({-0.4, 0.272, 0.02}));  // still level, as before
}

TEST_CASE("self filter: rays that pass a flipper's edge are shadowed, others are not") {
  SelfFilterConfig config = absolem();
  const rt::Vector3 sensor{0.1, 0.0, 0.5};
  CHECK(!SelfFilter(config).is_shadowed(sensor, {1.0, 0.6, 0.0}));
  config.shadow_m = 0.05;
  const SelfFilter filter(config);
  std::mt19937_64 random(3);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  // A twin that looks at the way in steps of 2 mm.
  int shadowed = 0;
  for (int i = 0; i < 4000; ++i) {
    // Seen through a place on the robot or beside it, up to four times as far.
    const rt::Vector3 through{uniform(-0.7, 0.7), uniform(-0.5, 0.5), uniform(0.0, 0.4)};
    const rt::Vector3 p = sensor + uniform(1.0, 4.0) * (through - sensor);
    const rt::Vector3 way = p - sensor;
    const double range = rt::norm(way);
    bool near = false;    // within the margin, well inside
    bool around = false;  // within a little more than the margin
    SelfFilterConfig less = config;
    SelfFilterConfig more = config;
    less.margin_m = 0.02;
    more.margin_m = 0.055;
    const SelfFilter inner(less);
    const SelfFilter outer(more);
    for (double along = 0.15; along < range; along += 0.002) {
      near = near || inner.is_robot(sensor + (along / range) * way);
      around = around || outer.is_robot(sensor + (along / range) * way);
    }
    const bool says = filter.is_shadowed(sensor, p);
    if (near) CHECK(says);
    if (!around) CHECK(!says);
    shadowed += says ? 1 : 0;
  }
  CHECK(shadowed > 100);
  CHECK(shadowed < 3000);
}

}  // namespace sortie::mapping
