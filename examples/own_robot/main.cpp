// SPDX-License-Identifier: BSD-3-Clause
// The robot: which device feeds which task, what stands in for the device on a desk, and the program.
#include <tuple>

#include "drivers/can_stub.hpp"
#include "firmware_like/can_input.hpp"
#include "firmware_like/own_program.hpp"
#include "gas.hpp"

using namespace sortie;

class GasRobot final : public firmware::Vehicle {
 public:
  explicit GasRobot(firmware::VehicleBuilder& robot) {
    alarm_ppm_ = robot.profile().number("gas.alarm_ppm", {50, 0, 1e4, "ppm", "mean that is too much"});
    const rt::GroupId sensing = robot.group("sensing", 50);
    std::tie(samples_, port_) = robot.stream<GasSample>(sensing, "GAS", 64, 16);
    auto* alarm = robot.task<GasState>(sensing, "gas_alarm", 20, [this](rt::JobContext&, GasState& output) {
      for (const GasSample& sample : *samples_) output.update(sample, alarm_ppm_);
    });
    robot.remembers(alarm);  // nothing beside its output
  }
  void poll_devices(const firmware::Devices& devices, rt::Nanoseconds now_ns) override {
    drivers::CanFrame frame;
    GasSample sample;
    while (firmware::receive_can(devices, now_ns, frame) == Status::ok)
      if (decode(frame, sample) == Status::ok) (void)port_->push(sample, now_ns);  // a refusal is counted
  }

 private:
  double alarm_ppm_{};
  rt::Stream<GasSample>* samples_{};
  firmware::InputPort<GasSample>* port_{};
};

class Plume final : public firmware::BenchRobot {  // without --can: a sensor that smells a plume each second
 public:
  explicit Plume(firmware::Profile& profile)
      : peak_ppm_(profile.integer("hil.peak_ppm", {100, 0, 60000, "ppm", "of the plume"})) {}
  void step(rt::Nanoseconds now_ns) override {
    for (; next_ns_ <= now_ns; next_ns_ += 20'000'000) {
      const auto phase = next_ns_ / 20'000'000 % 50;
      const auto ppm = static_cast<std::uint16_t>(peak_ppm_ * phase * (50 - phase) / 625);
      (void)sensor_.send({next_ns_, 0x150, 2, 0, {std::uint8_t(ppm & 255), std::uint8_t(ppm >> 8)}});
    }
    bus_.advance(now_ns);
  }
  drivers::CanBus* vehicle_can() override { return &robot_; }

 private:
  std::int64_t peak_ppm_;
  rt::Nanoseconds next_ns_{};
  drivers::CanStub bus_;
  drivers::CanBus& robot_{bus_.attach("robot")};
  drivers::CanBus& sensor_{bus_.attach("sensor")};
};

int main(int argc, char** argv) {
  const firmware::VehicleRegistry vehicles{{"gas", firmware::make_vehicle<GasRobot>}};
  return firmware::run_own_program(argc, argv, {"gas_robot", vehicles, firmware::make_bench<Plume>});
}
