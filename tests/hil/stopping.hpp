// SPDX-License-Identifier: BSD-3-Clause
// How long, and over what way, a robot's tracks take from a cause to standing or being without torque: many
// runs with a seed each.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "hil/random.hpp"
#include "tests/hil/drives_model.hpp"

namespace sortie::hil::test {

/// Why it stops.
enum class StopCause : std::uint8_t {
  silence,
  loss,
  mute,
  fault,
  bus_off,
  process_stopped,
  process_killed,
  emergency_stop,
};
inline constexpr const char* kStopCauses[] = {"a source falls silent",         "a drive loses its power",
                                              "a drive is not read any more",  "a drive has a fault",
                                              "our controller is off the bus", "the process is stopped",
                                              "the process is killed",         "emergency stop"};

/// The promise of docs/safety.md, from the cause until no wheel is driven: each stands, or has no torque.
/// Ramps: 0.6 m/s at 4 m/s^2 of a quick stop (CANopen) or with all that the motor has; down a slope of 20
/// degrees the motor's 5 m/s^2 have 3.4 less.
struct StopPromise {
  int ms;
  double m;
};

/// What was found.
struct StopFigures {
  std::vector<double> ms;
  double worst_m{};   ///< until then
  double rolled_m{};  ///< until it stands, or in two seconds
  int refused{};      ///< runs that did not begin
};

template <class Kind>
void stop_once(std::uint64_t seed, StopCause cause, bool slope, StopFigures& figures) {
  Random random(seed, static_cast<std::uint64_t>(cause));
  const auto between = [&random](double low, double high) { return low + (high - low) * random.uniform(); };
  constexpr double kSlope_m_s2 = 3.36;  // 9.81 sin 20 degrees
  DrivesWorld<Kind> world;
  for (std::size_t i = 0; i < 2; ++i) {
    world.axis(i).config().motor_s2 = between(5.0, 7.0) * Kind::kPerM;
    world.axis(i).config().friction_s2 = between(0.3, 0.8) * Kind::kPerM;
  }
  world.drive_.left_m_s = between(0.1, 0.6);
  world.drive_.right_m_s = slope ? between(0.1, 0.6) : between(-0.6, 0.6);
  if (!world.bring_up()) {
    ++figures.refused;
    return;
  }
  // It came from the flat: without torque nothing would have held it here.
  for (std::size_t i = 0; i < 2; ++i)
    world.axis(i).config().slope_s2 = slope ? kSlope_m_s2 * Kind::kPerM : 0.0;
  world.run(100 + static_cast<int>(between(0.0, 120.0)));
  switch (cause) {
    case StopCause::silence:
      world.drive_speaks_ = false;
      break;
    case StopCause::loss:
      world.node(1).set_power(false);
      break;
    case StopCause::mute:
      Kind::mute(world.node(1), true);
      break;
    case StopCause::fault:
      Kind::fault(world.node(1));
      break;
    case StopCause::bus_off:
      world.set_bus_off(true);
      break;
    case StopCause::process_stopped:
      world.starved_ = true;
      break;
    case StopCause::process_killed:
      world.lives_ = false;
      break;
    case StopCause::emergency_stop:
      world.runtime().press(true);
      break;
  }
  const double from[] = {world.position(0), world.position(1)};
  const auto way = [&](std::size_t i) { return std::fabs(world.position(i) - from[i]); };
  int last_ms = 0;
  double at_m[2]{};
  for (int ms = 1; ms <= 2000; ++ms) {
    world.step();
    for (std::size_t i = 0; i < 2; ++i) {
      if (!Kind::torque(world.node(i)) || std::fabs(world.speed(i)) < 0.01) continue;
      last_ms = ms;
      at_m[i] = way(i);
    }
  }
  figures.ms.push_back(last_ms);
  figures.worst_m = std::max({figures.worst_m, at_m[0], at_m[1]});
  figures.rolled_m = std::max({figures.rolled_m, way(0), way(1)});
}

/// Worst of `runs` seeds from `seed` on.
template <class Kind>
StopFigures stop_many(std::uint64_t seed, int runs, StopCause cause, bool slope) {
  StopFigures figures;
  for (int i = 0; i < runs; ++i) stop_once<Kind>(seed + static_cast<std::uint64_t>(i), cause, slope, figures);
  std::sort(figures.ms.begin(), figures.ms.end());
  return figures;
}

/// A long row of deeds at random moments, judged. Empty, or what is against the promise.
template <class Kind>
std::string random_row(std::uint64_t seed, int deeds) {
  Random random(seed, 77);
  const rt::Nanoseconds rearm_ns = random.uniform() < 0.3 ? 300 * rt::kNanosecondsPerMillisecond : 0;
  const bool flippers = random.uniform() < 0.4;
  DrivesModel<Kind> model = asked_model<Kind>(flippers, rearm_ns, static_cast<int>(3000 * random.uniform()));
  std::string row;
  for (int i = 0; i < deeds && model.found.empty(); ++i) {
    const int deed = static_cast<int>(model.deeds() * random.uniform());
    const double r = random.uniform();
    const int dwell = static_cast<int>(r < 0.5 ? 40 * random.uniform() : 900 * random.uniform());
    row += " " + std::to_string(deed) + "/" + std::to_string(dwell);
    model.act(static_cast<Deed>(deed));
    model.pass(dwell);
  }
  return model.found.empty() ? std::string() : model.found + ", seed " + std::to_string(seed) + ", row" + row;
}

/// What docs/safety.md promises.
template <class Kind>
StopPromise promised(StopCause cause, bool slope) {
  constexpr bool kCanopen = std::is_same_v<Kind, CanopenKind>;
  // From the cause until the order to stop has come to the drives.
  int told_ms = 25;
  if (cause == StopCause::silence) told_ms = 225;
  if (cause == StopCause::fault) told_ms = kCanopen ? 25 : 75;
  if (cause == StopCause::mute) told_ms = kCanopen ? 80 : 175;
  if (cause == StopCause::loss) told_ms = kCanopen ? 80 : 175;
  if (cause >= StopCause::bus_off && cause <= StopCause::process_killed) told_ms = kCanopen ? 160 : 115;
  // From then on. An ODrive whose watchdog has ended is without torque at once.
  const bool let_go = !kCanopen && cause >= StopCause::bus_off && cause <= StopCause::process_killed;
  const int ramp_ms = let_go ? 0 : slope ? 440 : kCanopen ? 160 : 140;
  return {told_ms + ramp_ms, 1e-3 * 0.6 * (told_ms + 0.5 * ramp_ms) + 0.02};
}

}  // namespace sortie::hil::test
