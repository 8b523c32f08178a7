// SPDX-License-Identifier: BSD-3-Clause
// A bus in memory with the robot's drives at one end, and simulated ones that turn axes with inertia,
// friction and a slope at the other.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "drivers/can_stub.hpp"
#include "drivers/canopen/ugv_nodes.hpp"
#include "hil/canopen/node.hpp"
#include "hil/drive_axis.hpp"
#include "tests/hil/asker.hpp"

namespace sortie::hil::test {

/// Two tracks (nodes 1, 2) and four flippers (11 to 14).
class CanopenRig {
 public:
  static constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;

  explicit CanopenRig(const drivers::CanStubConfig& bus = {},
                      const drivers::canopen::UgvNodesConfig& config = {})
      : stub_(bus), port_(&stub_.attach("runtime")), listener_(&stub_.attach("listener")) {
    for (const std::uint8_t number : std::initializer_list<std::uint8_t>{1, 2, 11, 12, 13, 14}) {
      ports_.push_back(&stub_.attach("drive " + std::to_string(number)));
      nodes_.push_back(std::make_unique<CanopenNode>(number, *ports_.back()));
    }
    // 10,000 increments a metre: 6 m/s^2 of the motor, 0.5 m/s^2 of friction.
    motors_.assign(nodes_.size(), DriveAxis({.motor_s2 = 60'000.0, .friction_s2 = 5'000.0}));
    restart(config);
  }

  void restart(const drivers::canopen::UgvNodesConfig& config = {}) {
    drive_asks_.begin_anew();
    flippers_ask_.begin_anew();
    drives_ = std::make_unique<drivers::canopen::UgvNodes>(config);
    lives_ = true;
  }
  void kill() { lives_ = false; }

  /// Lets `ms` milliseconds pass; commands are renewed in each.
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ += kMs;
      if (lives_) {
        drivers::CanFrame frame;
        while (port_->receive(frame) == Status::ok) static_cast<void>(drives_->take(frame, now_));
        if (commands_) command();
        drives_->poll(now_, *port_);
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
    run(2500);
    armed_ = true;
    run(600);
    return drives().running() && std::all_of(nodes_.begin(), nodes_.end(), [](const auto& node) {
             return node->state() == drivers::canopen::DriveState::operation_enabled;
           });
  }
  bool all_still() const {
    return std::all_of(motors_.begin(), motors_.end(),
                       [](const DriveAxis& m) { return std::fabs(m.speed()) < 1.0; });
  }

  drivers::canopen::UgvNodes& drives() { return *drives_; }
  const drivers::canopen::Drive& drive(std::size_t i) const { return drives_->line().drive(i); }
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

  /// Increments a second of the tracks, increments of the front flippers.
  std::vector<std::int32_t> targets_{5000, -3000, 2000, -2000};
  bool armed_{};
  bool commands_{true};

 private:
  void command() {
    rt::DriveCommand drive;
    drive.stamp_ns = now_;
    drive.left_m_s = 1e-4 * targets_[0];
    drive.right_m_s = 1e-4 * targets_[1];
    rt::FlipperCommand flippers;
    flippers.stamp_ns = now_;
    for (std::size_t i = 0; i < 2; ++i) flippers.angle_rad[i] = 1e-4 * targets_[2 + i];
    drive.flags = flippers.flags = armed_ ? 1u : 0u;
    drive_asks_(drive);
    flippers_ask_(flippers);
    // Finite, and of this moment.
    static_cast<void>(drives_->set(drive, now_));
    static_cast<void>(drives_->set(flippers, now_));
  }

  Asker drive_asks_, flippers_ask_;
  drivers::CanStub stub_;
  drivers::CanBus* port_;
  drivers::CanBus* listener_;
  std::vector<drivers::CanBus*> ports_;
  std::vector<std::unique_ptr<CanopenNode>> nodes_;
  std::vector<DriveAxis> motors_;
  std::unique_ptr<drivers::canopen::UgvNodes> drives_;
  std::vector<drivers::CanFrame> seen_;
  rt::Nanoseconds now_{};
  bool lives_{};
};

}  // namespace sortie::hil::test
