// SPDX-License-Identifier: BSD-3-Clause
// The degrade ladder against a model of a core: what it sheds, in which order, and how soon it gives it back.
#include "rt/ladder.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <limits>
#include <random>

namespace sortie::rt {
namespace {

// Declared load of A, B and C at each level.
std::array<double, kLevels> declared_loads(const std::array<double, 3>& parts) {
  std::array<double, kLevels> loads{};
  for (std::uint8_t level = 0; level < kLevels; ++level) {
    for (std::size_t part = 0; part < 3; ++part) {
      const Service service = service_at(static_cast<Criticality>(part), level);
      const double share = service == Service::full ? 1.0 : service == Service::reduced ? 0.5 : 0.0;
      loads[level] += share * parts[part];
    }
  }
  return loads;
}

// A core whose tasks take `factor` times what they declare: what it measures saturates at one.
double measured(const std::array<double, 3>& parts, const std::array<double, 3>& factor, std::uint8_t level) {
  std::array<double, 3> real{};
  for (std::size_t i = 0; i < 3; ++i) real[i] = parts[i] * factor[i];
  return std::min(1.0, declared_loads(real)[level]);
}

}  // namespace

TEST_CASE("criticality C gives way before B, and A never") {
  for (std::uint8_t level = 0; level < kLevels; ++level) {
    CHECK(service_at(Criticality::a, level) == Service::full);
    if (service_at(Criticality::b, level) != Service::full)
      CHECK(service_at(Criticality::c, level) == Service::off);
    if (level == 0) continue;
    const auto before = static_cast<std::uint8_t>(level - 1);
    for (const Criticality c : {Criticality::b, Criticality::c})
      CHECK(service_at(c, level) >= service_at(c, before));
  }
  CHECK(service_at(Criticality::b, kTopLevel) == Service::off);
}

TEST_CASE("at twice the demand the ladder settles within three windows and is back within ten") {
  const LadderConfig config;
  constexpr std::uint32_t kSeed = 99;
  INFO("seed " << kSeed);
  std::minstd_rand random(kSeed);
  const auto unit = [&random] { return static_cast<double>(random() % 1000) / 1000.0; };
  int tried = 0;
  for (int round = 0; round < 2000; ++round) {
    // Any mix that fits, and of which A alone fits at twice its demand.
    const std::array<double, 3> parts{0.05 + 0.3 * unit(), 0.3 * unit(), 0.3 * unit()};
    if (parts[0] + parts[1] + parts[2] > 0.74) continue;
    ++tried;
    Ladder ladder(config, declared_loads(parts));
    const std::array<double, 3> calm{1, 1, 1};
    const std::array<double, 3> twice{2, 2, 2};
    for (int window = 0; window < 20; ++window)
      REQUIRE(ladder.update(measured(parts, calm, ladder.level()), false) == 0);
    for (int window = 0; window < 3; ++window) ladder.update(measured(parts, twice, ladder.level()), false);
    const std::uint8_t settled = ladder.level();
    INFO("parts " << parts[0] << ' ' << parts[1] << ' ' << parts[2] << " level " << int{settled});
    REQUIRE(measured(parts, twice, settled) <= config.most_load);
    int over = 0;
    for (int window = 0; window < 100; ++window) {
      const double load = measured(parts, twice, ladder.level());
      over += load > config.most_load ? 1 : 0;
      ladder.update(load, false);
    }
    REQUIRE(over <= 100 / (config.most_backoff - 1));  // a failed try now and then, no oscillation
    int back = 0;
    while (ladder.level() != 0) {
      ladder.update(measured(parts, calm, ladder.level()), false);
      REQUIRE(++back <= 10);
    }
  }
  CHECK(tried > 1000);
}

TEST_CASE("a missed criticality-A job climbs at once, whatever the load says, and NaN counts as full") {
  Ladder ladder({}, declared_loads({0.2, 0.2, 0.2}));
  CHECK(ladder.update(0.1, true) >= 1);
  Ladder other({}, declared_loads({0.2, 0.2, 0.2}));
  CHECK(other.update(std::numeric_limits<double>::quiet_NaN(), false) >= 1);
  for (int i = 0; i < 10; ++i) other.update(std::numeric_limits<double>::quiet_NaN(), true);
  CHECK(other.level() == kTopLevel);
}

TEST_CASE("each level is held for its own calm windows before the next lower one is tried") {
  LadderConfig config;
  config.calm_windows = 3;
  // By these declarations each level is one fifth of the one below: only one step down is ever foreseen to
  // fit.
  Ladder ladder(config, {0.625, 0.125, 0.025, 0.005, 0.001});
  for (int i = 0; i < 10; ++i) ladder.update(1.0, true);
  REQUIRE(ladder.level() == kTopLevel);
  for (int next = kTopLevel - 1; next >= 0; --next) {
    for (int window = 0; window < config.calm_windows; ++window) {
      REQUIRE(int{ladder.level()} == next + 1);
      ladder.update(0.14, false);  // five times of it fit below return_load, twenty-five times do not
    }
    REQUIRE(int{ladder.level()} == next);
  }
}

TEST_CASE("what is C's fault alone is tried again rarely, and never forgotten") {
  const LadderConfig config;
  const std::array<double, 3> parts{0.2, 0.2, 0.2};
  Ladder ladder(config, declared_loads(parts));
  int tries = 0;
  std::uint8_t before = 0;
  for (int window = 0; window < 400; ++window) {
    const std::uint8_t level = ladder.update(measured(parts, {1, 1, 4}, ladder.level()), false);
    if (level < before) ++tries;
    before = level;
  }
  CHECK(tries > 10);
  CHECK(tries <= 400 / config.most_backoff);
  int back = 0;
  while (ladder.level() != 0) {
    ladder.update(measured(parts, {1, 1, 1}, ladder.level()), false);
    REQUIRE(++back <= 10);
  }
}

TEST_CASE("a slow group's single job is no overload as long as the mean over its period is not") {
  LadderConfig config;
  config.span = 10;
  Ladder ladder(config, declared_loads({0.2, 0.3, 0.2}));
  // Every tenth window is full, and the ones before it too: 0.7 on average.
  for (int window = 0; window < 1000; ++window) {
    const double load = window % 10 < 6 ? 1.0 : 0.25;
    REQUIRE(ladder.update(load, false) == 0);
  }
  int windows = 0;
  while (ladder.update(1.0, false) == 0) REQUIRE(++windows <= 10);
}

}  // namespace sortie::rt
