// SPDX-License-Identifier: BSD-3-Clause
// The errors of range sensors: their statistics against what was asked for, with the truth beside them.
#include "hil/range_noise.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "hil/ssl_sensor.hpp"
#include "tests/hil/sensor_bench.hpp"

namespace sortie::hil {
namespace {

// A wall 20 m wide in front of a sensor at the origin of a body, its face at x = `face_m`.
struct WallBench {
  explicit WallBench(double face_m, std::uint16_t reflectivity = 100) {
    REQUIRE(world.add(make_box({face_m + 0.5, 0, 0, 1, 2000, 0, 900}, reflectivity)) == Status::ok);
    REQUIRE(world.finalize() == Status::ok);
    REQUIRE(caster.aim({{0, 0, 1}, {}}, {}, aim) == Status::ok);
  }
  World world;
  RayCaster caster{world};
  RayCaster::Aim aim;
};

RangeNoiseConfig no_errors() {
  RangeNoiseConfig config;
  config.sigma_m = 0.0;
  config.loss = 0.0;
  return config;
}

Vec3 flat_ray(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad), 0.0}; }

}  // namespace

TEST_CASE("range errors are normal, with the bias and deviation asked for") {
  const WallBench bench(5.0);
  RangeNoiseConfig config = no_errors();
  config.sigma_m = 0.02;
  config.sigma_share = 0.004;  // at 5 m: 0.04 in all
  config.bias_m = -0.03;
  RangeNoise noise(config, 0.1, 50.0, "test");
  noise.begin(81, 1);
  INFO("seed 81");
  constexpr int kRays = 40000;
  constexpr int kBins = 16;
  // Edges of 16 equally likely bins of the standard normal, upper half.
  const double edges[7] = {0.15731, 0.31864, 0.48878, 0.67449, 0.88715, 1.15035, 1.53412};
  int bins[kBins]{};
  double sum = 0.0;
  double sum2 = 0.0;
  for (int i = 0; i < kRays; ++i) {
    const RangeReading reading = noise.fire(bench.caster, bench.aim, {1, 0, 0});
    REQUIRE(reading.fate == RayFate::returned);
    REQUIRE(reading.truth.range_m == 5.0);
    const double error = (reading.range_m - 5.0 + 0.03) / 0.04;
    sum += error;
    sum2 += error * error;
    int bin = 0;
    while (bin < 7 && std::fabs(error) > edges[bin]) ++bin;
    ++bins[error < 0.0 ? 7 - bin : 8 + bin];
  }
  const double n = kRays;
  CHECK(std::fabs(sum / n) < 4.0 / std::sqrt(n));
  CHECK(std::fabs(sum2 / n - 1.0) < 4.0 * std::sqrt(2.0 / n));
  double chi2 = 0.0;
  for (const int count : bins) chi2 += (count - n / kBins) * (count - n / kBins) / (n / kBins);
  CHECK(chi2 < 44.3);  // 15 degrees of freedom, exceeded in 1 of 10,000
  CHECK(chi2 > 2.0);   // nor too even
}

TEST_CASE("quantised ranges are whole steps, at most half a step off") {
  const WallBench bench(5.0);
  RangeNoiseConfig config = no_errors();
  config.resolution_m = 0.004;
  RangeNoise noise(config, 0.1, 50.0, "test");
  noise.begin(1, 1);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const RangeReading reading = noise.fire(bench.caster, bench.aim, flat_ray(0.0011 * i));
    const double steps = reading.range_m / 0.004;
    REQUIRE(std::fabs(steps - std::nearbyint(steps)) < 1e-9);
    worst = std::fmax(worst, std::fabs(reading.range_m - reading.truth.range_m));
  }
  CHECK(worst <= 0.002 + 1e-12);
  CHECK(worst > 0.0019);
}

TEST_CASE("returns are lost by share, by incidence and by distance as often as the model says") {
  struct Case {
    double loss, graze_cos, full_range_m, face_m, angle_rad, expected;
  };
  const Case cases[] = {{0.2, 0, 0, 5, 0.3, 0.8},
                        {0.0, 0.5, 0, 5, 1.318116071652818, 0.5},                 // cos = 0.25
                        {0.0, 0.5, 0, 5, 1.0, 1.0},                               // steeper than that
                        {0.0, 0, 10, 20, 0, 0.25},                                // twice as far: a quarter
                        {0.0, 0, 10, 9.5, 0, 1.0},                                // nearer
                        {0.1, 0.5, 10, 5, 1.318116071652818, 0.9 * 0.5 * 0.25}};  // all: at 20 m
  INFO("seed 82");
  for (const Case& c : cases) {
    const WallBench bench(c.face_m);
    RangeNoiseConfig config = no_errors();
    config.loss = c.loss;
    config.graze_cos = c.graze_cos;
    config.full_range_m = c.full_range_m;
    RangeNoise noise(config, 0.1, 100.0, "test");
    noise.begin(82, 1);
    constexpr int kRays = 20000;
    for (int i = 0; i < kRays; ++i)
      static_cast<void>(noise.fire(bench.caster, bench.aim, flat_ray(c.angle_rad)));
    const RangeCounters& n = noise.counters();
    CHECK(n.rays == kRays);
    CHECK(n.rays == n.returned + n.nothing + n.lost + n.weak + n.too_near + n.too_far);
    const double margin = 4.0 * std::sqrt(kRays * c.expected * (1.0 - c.expected));
    CHECK(static_cast<double>(n.returned) == Approx(kRays * c.expected).margin(margin));
    if (c.loss == 0.0) CHECK(n.lost == 0);
  }
}

TEST_CASE("what is nearer or farther than a sensor reports is none of its returns") {
  const WallBench bench(5.0);
  RangeNoiseConfig config = no_errors();
  config.bias_m = -0.5;
  RangeNoise near(config, 4.6, 50.0, "test");
  near.begin(1, 1);
  CHECK(near.fire(bench.caster, bench.aim, {1, 0, 0}).fate == RayFate::too_near);
  config.bias_m = 0.5;
  RangeNoise far(config, 0.1, 5.4, "test");
  far.begin(1, 1);
  CHECK(far.fire(bench.caster, bench.aim, {1, 0, 0}).fate == RayFate::too_far);
  RangeNoise blind(config, 0.1, 4.9, "test");
  blind.begin(1, 1);
  const RangeReading nothing = blind.fire(bench.caster, bench.aim, {1, 0, 0});
  CHECK(nothing.fate == RayFate::nothing);
  CHECK(nothing.truth.solid == Hit::kNothing);
  CHECK(nothing.truth.range_m == 4.9);
  CHECK(blind.counters().nothing == 1);
}

TEST_CASE("mixed pixels lie between the two sides of an edge, and only there") {
  World world;
  REQUIRE(world.add(make_box({3.5, -10, 0, 1, 20, 0, 3})) == Status::ok);  // face at x = 3 for y < 0
  REQUIRE(world.add(make_box({6.5, 0, 0, 1, 40, 0, 3})) == Status::ok);    // face at x = 6
  REQUIRE(world.finalize() == Status::ok);
  const RayCaster caster(world);
  RayCaster::Aim aim;
  REQUIRE(caster.aim({{0, 0, 1.5}, {}}, {}, aim) == Status::ok);
  RangeNoiseConfig config = no_errors();
  config.divergence_rad = 0.004;
  RangeNoise noise(config, 0.1, 50.0, "test");
  noise.begin(83, 1);
  INFO("seed 83");
  int mixed = 0;
  int beyond = 0;
  for (int i = -2000; i <= 2000; ++i) {
    const double angle = 1e-5 * i;  // the edge is at 0, and belongs to the near wall
    const RangeReading reading = noise.fire(caster, aim, flat_ray(angle));
    REQUIRE(reading.fate == RayFate::returned);
    REQUIRE(reading.truth.range_m == Approx((i <= 0 ? 3.0 : 6.0) / std::cos(angle)).epsilon(1e-9));
    if (!reading.truth.mixed) {
      REQUIRE(reading.range_m == reading.truth.range_m);
      continue;
    }
    ++mixed;
    REQUIRE(reading.range_m >= 2.999);
    REQUIRE(reading.range_m <= 6.001);
    REQUIRE(std::fabs(angle) <= 0.004 + 1e-12);
    beyond += reading.range_m > 3.2 && reading.range_m < 5.8 ? 1 : 0;
  }
  // Of the beam's rim, at an angle a beside the edge acos(a / divergence) / pi lies across it; on average 1 /
  // pi.
  CHECK(mixed == Approx(801 / kPi).margin(4.0 * std::sqrt(801 / kPi)));
  CHECK(beyond > mixed / 2);
  CHECK(noise.counters().mixed == static_cast<std::uint64_t>(mixed));
}

TEST_CASE("stamps jitter as asked, within four deviations, and errors switched off draw nothing") {
  RangeNoiseConfig config = no_errors();
  config.stamp_jitter_ns = 50'000;
  RangeNoise noise(config, 0.1, 50.0, "test");
  double sum2 = 0.0;
  constexpr int kScans = 20000;
  INFO("seed 84");
  for (int i = 0; i < kScans; ++i) {
    noise.begin(84, static_cast<std::uint64_t>(i));
    const auto error = static_cast<double>(noise.stamp_error_ns());
    REQUIRE(std::fabs(error) <= 200'000);
    sum2 += error * error;
  }
  CHECK(std::sqrt(sum2 / kScans) == Approx(50'000).epsilon(4.0 / std::sqrt(2.0 * kScans)));
  RangeNoise still(no_errors(), 0.1, 50.0, "test");
  CHECK(still.stamp_error_ns() == 0);
}

TEST_CASE("one error more does not change the others' draws") {
  const WallBench bench(5.0);
  RangeNoiseConfig plain;
  RangeNoiseConfig all = plain;
  all.graze_cos = 1e-9;
  all.full_range_m = 900.0;
  all.divergence_rad = 1e-6;
  all.stamp_jitter_ns = 1000;
  RangeNoise a(plain, 0.1, 50.0, "test");
  RangeNoise b(all, 0.1, 50.0, "test");
  a.begin(85, 1);
  b.begin(85, 1);
  for (int i = 0; i < 2000; ++i) {
    const RangeReading left = a.fire(bench.caster, bench.aim, flat_ray(0.0005 * i));
    const RangeReading right = b.fire(bench.caster, bench.aim, flat_ray(0.0005 * i));
    REQUIRE(left.range_m == right.range_m);
    REQUIRE(left.fate == right.fate);
  }
}

TEST_CASE("errors that cannot be say which setting to change") {
  const auto complaint = [](auto change) {
    RangeNoiseConfig config;
    change(config);
    try {
      RangeNoise(config, 0.1, 50.0, "who");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(complaint([](RangeNoiseConfig&) {}).empty());
  CHECK(complaint([](RangeNoiseConfig& c) { c.sigma_m = -1; }).find("hil who: sigma_m") == 0);
  CHECK(complaint([](RangeNoiseConfig& c) { c.bias_m = std::nan(""); }).find("bias_m") != std::string::npos);
  CHECK(complaint([](RangeNoiseConfig& c) { c.loss = 2; }).find("loss") != std::string::npos);
  CHECK(complaint([](RangeNoiseConfig& c) { c.divergence_rad = 1; }).find("divergence_rad") !=
        std::string::npos);
  CHECK(complaint([](RangeNoiseConfig& c) { c.stamp_jitter_ns = -1; }).find("stamp_jitter_ns") !=
        std::string::npos);
  SslConfig ssl;
  ssl.max_range_m = 70;
  CHECK_THROWS_WITH(SslSensor(ssl, {}, 1, 0), Catch::Contains("max_range_m"));
}

}  // namespace sortie::hil
