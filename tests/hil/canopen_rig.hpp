// SPDX-License-Identifier: BSD-3-Clause
// A bus in memory with a master and simulated drives that turn axes with inertia, friction and a slope.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "drivers/can_stub.hpp"
#include "drivers/canopen/master.hpp"
#include "hil/canopen/node.hpp"
#include "hil/drive_axis.hpp"

namespace sortie::hil::test {

/// Two velocity drives (nodes 1, 2) and two position drives (11, 12).
class CanopenRig {
 public:
  static constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;

  explicit CanopenRig(const drivers::CanStubConfig& bus = {},
                      const drivers::canopen::MasterConfig& config = {})
      : stub_(bus), port_(&stub_.attach("master")), listener_(&stub_.attach("listener")) {
    for (const std::uint8_t number : std::initializer_list<std::uint8_t>{1, 2, 11, 12}) {
      drivers::canopen::DriveConfig drive;
      drive.node = number;
      drive.kind =
          number < 10 ? drivers::canopen::DriveKind::velocity : drivers::canopen::DriveKind::cyclic_position;
      configs_.push_back(drive);
      ports_.push_back(&stub_.attach("drive " + std::to_string(number)));
      nodes_.push_back(std::make_unique<CanopenNode>(number, *ports_.back()));
    }
    // 10,000 increments a metre: 6 m/s^2 of the motor, 0.5 m/s^2 of friction.
    motors_.assign(nodes_.size(), DriveAxis({.motor_s2 = 60'000.0, .friction_s2 = 5'000.0}));
    restart_master(config);
  }

  void restart_master(const drivers::canopen::MasterConfig& config = {}) {
    master_ = std::make_unique<drivers::canopen::Master>(config, configs_);
    master_lives_ = true;
  }
  void kill_master() { master_lives_ = false; }

  /// Lets `ms` milliseconds pass; commands are renewed in each.
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ += kMs;
      if (master_lives_) {
        drivers::CanFrame frame;
        while (port_->receive(frame) == Status::ok) static_cast<void>(master_->take(frame, now_));
        if (commands_) master_->set(targets_, armed_, now_);
        master_->poll(now_, *port_);
      }
      for (std::size_t k = 0; k < nodes_.size(); ++k) {
        motors_[k].advance(nodes_[k]->wish(), 1e-3);
        nodes_[k]->show(motor(k));
        drivers::CanFrame frame;
        while (ports_[k]->receive(frame) == Status::ok) nodes_[k]->hear(frame, now_);
        nodes_[k]->step(now_);
      }
      stub_.advance(now_);
      drivers::CanFrame frame;
      while (listener_->receive(frame) == Status::ok) seen_.push_back(frame);
    }
  }

  /// All drives set up, then armed until they run.
  bool bring_up() {
    armed_ = false;
    run(1500);
    armed_ = true;
    run(200);
    return master().running() && std::all_of(nodes_.begin(), nodes_.end(), [](const auto& node) {
             return node->state() == drivers::canopen::DriveState::operation_enabled;
           });
  }
  bool all_still() const {
    return std::all_of(motors_.begin(), motors_.end(),
                       [](const DriveAxis& m) { return std::fabs(m.speed()) < 1.0; });
  }

  drivers::canopen::Master& master() { return *master_; }
  CanopenNode& node(std::size_t i) { return *nodes_[i]; }
  MotorState motor(std::size_t i) const {
    const auto whole = [](double value) { return static_cast<std::int32_t>(std::lround(value)); };
    return {whole(motors_[i].position()), whole(motors_[i].speed()), 0};
  }
  DriveAxis& axis(std::size_t i) { return motors_[i]; }
  drivers::CanStub& stub() { return stub_; }
  drivers::CanBus& listener() { return *listener_; }
  drivers::CanBus& master_port() { return *port_; }
  drivers::CanBus& port(std::size_t i) { return *ports_[i]; }
  const std::vector<drivers::CanFrame>& seen() const { return seen_; }
  rt::Nanoseconds now() const { return now_; }

  std::vector<std::int32_t> targets_{5000, -3000, 2000, -2000};
  bool armed_{};
  bool commands_{true};

 private:
  drivers::CanStub stub_;
  drivers::CanBus* port_;
  drivers::CanBus* listener_;
  std::vector<drivers::CanBus*> ports_;
  std::vector<drivers::canopen::DriveConfig> configs_;
  std::vector<std::unique_ptr<CanopenNode>> nodes_;
  std::vector<DriveAxis> motors_;
  std::unique_ptr<drivers::canopen::Master> master_;
  std::vector<drivers::CanFrame> seen_;
  rt::Nanoseconds now_{};
  bool master_lives_{};
};

}  // namespace sortie::hil::test
