// SPDX-License-Identifier: BSD-3-Clause
// A bus in memory with the runtime's side of the motors at one end, simulated drives and a body at the other.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "drivers/can_load.hpp"
#include "drivers/can_stub.hpp"
#include "drivers/ugv_drives.hpp"
#include "hil/motor_wishes.hpp"
#include "tests/hil/asker.hpp"

namespace sortie::hil::test {

/// Tracks do at once what they are told, and roll out at 0.5 m/s^2 without torque; flippers turn at 2 rad/s.
class MotorsPuppet final : public VehicleBody {
 public:
  Status set_command(const rt::DriveCommand& command, rt::Nanoseconds) override {
    drive_ = command;
    return Status::ok;
  }
  Status set_flippers(const drivers::FlipperPairCommand& command) override {
    if ((command.flags & 1u) == 0) return Status::ok;
    const std::size_t left = command.pair == drivers::FlipperPair::front ? 0 : 2;
    wanted_rad_[left] = command.left_rad;
    wanted_rad_[left + 1] = command.right_rad;
    moves_ = true;
    return Status::ok;
  }
  void let_go(bool left, bool right) override { free_[0] = left, free_[1] = right; }
  void step() override {
    const double wishes[] = {drive_.left_m_s, drive_.right_m_s};
    for (int i = 0; i < 2; ++i)
      speed_m_s_[i] = free_[i] ? speed_m_s_[i] - std::clamp(speed_m_s_[i], -5e-4, 5e-4) : wishes[i];
    motion_.left_m += 1e-3 * speed_m_s_[0];
    motion_.right_m += 1e-3 * speed_m_s_[1];
    for (std::size_t i = 0; moves_ && i < rt::kFlippers; ++i)
      flippers_.angle_rad[i] += std::clamp(wanted_rad_[i] - flippers_.angle_rad[i], -2e-3, 2e-3);
  }
  const Motion& motion() const override { return motion_; }
  bool read_flippers(rt::FlipperSample& sample) const override {
    sample = flippers_;
    return true;
  }
  RobotCounters counters() const override { return {}; }

  Motion motion_{};
  rt::DriveCommand drive_{};
  rt::FlipperSample flippers_{};

 private:
  double wanted_rad_[rt::kFlippers]{};
  double speed_m_s_[2]{};
  bool free_[2]{};
  bool moves_{};
};

/// Both ends. The newest samples, and how many there were.
template <class Runtime, class RuntimeConfig, class Drives, class DrivesConfig>
struct MotorsVehicle {
  MotorsVehicle() {
    body.flippers_.angle_rad[0] = 0.25;
    body.flippers_.torque_n_m[3] = -12.5;
  }
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now += rt::kNanosecondsPerMillisecond;
      drivers::CanFrame frame;
      while (ours.receive(frame) == Status::ok) static_cast<void>(runtime.take(frame, now));
      drive_asks(drive);
      flippers_ask(flippers);
      REQUIRE(runtime.set(drive, now) == Status::ok);
      REQUIRE(runtime.set(flippers, now) == Status::ok);
      runtime.poll(now, ours);
      if (runtime.read(track) == Status::ok) ++tracks;
      if (runtime.read(flipper) == Status::ok) ++states;
      if constexpr (requires { drives.show(body, now); }) {
        drives.show(body, now);
      } else {
        drives.show(body);
      }
      while (theirs.receive(frame) == Status::ok) drives.hear(frame, now);
      drives.step(body, now);
      body.step();
      bus.advance(now);
    }
  }

  /// Empty, or which frames on the bus are not those that were declared, or not as often, while nothing
  /// changes.
  std::string not_as_declared(const std::vector<drivers::CanStream>& declared, int seconds) {
    std::string faults;
    std::map<std::uint32_t, double> seen;
    drivers::CanFrame frame;
    while (listener.receive(frame) == Status::ok) continue;  // from before
    for (int ms = 0; ms < 1000 * seconds; ++ms) {
      run(1);
      while (listener.receive(frame) == Status::ok) ++seen[frame.id];
    }
    for (const drivers::CanStream& stream : declared) {
      const double expected = 1e9 * seconds / static_cast<double>(stream.period_ns);
      if (seen[stream.id] != Approx(expected).epsilon(0.02).margin(2))
        faults += stream.name + " " + std::to_string(seen[stream.id]) + " times, ";
      seen.erase(stream.id);
    }
    for (const auto& [id, count] : seen) {
      // A state asked for, an error forgotten.
      if (count > 2) faults += "undeclared " + std::to_string(id) + ", ";
    }
    return faults;
  }

  drivers::CanStub bus{drivers::CanStubConfig{}};
  drivers::CanBus& ours = bus.attach("runtime");
  drivers::CanBus& theirs = bus.attach("vehicle");
  drivers::CanBus& listener = bus.attach("listener");
  Runtime runtime{RuntimeConfig{}};
  DrivesConfig config{.enabled = true};
  Drives drives{config, theirs, true};
  MotorsPuppet body;
  rt::DriveCommand drive{};
  rt::FlipperCommand flippers{};
  Asker drive_asks, flippers_ask;
  rt::TrackSample track{};
  rt::FlipperSample flipper{};
  int tracks = 0, states = 0;
  rt::Nanoseconds now = 0;
};

}  // namespace sortie::hil::test
