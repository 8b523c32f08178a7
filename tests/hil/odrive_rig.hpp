// SPDX-License-Identifier: BSD-3-Clause
// A bus in memory with the robot's axes at one end, and at the other simulated ones that turn inertia against
// friction and a slope.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/can_stub.hpp"
#include "drivers/odrive/ugv_axes.hpp"
#include "hil/odrive/axis_node.hpp"
#include "tests/hil/asker.hpp"

namespace sortie::hil::test {

/// Two tracks (1, 2) and four flippers (11 to 14).
class OdriveRig {
 public:
  static constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
  static constexpr std::size_t kAxes = 6;

  explicit OdriveRig(const drivers::odrive::UgvAxesConfig& config = {}, const AxisNodeConfig& axis = {})
      : port_(&stub_.attach("group")), listener_(&stub_.attach("listener")) {
    for (const std::uint8_t number : std::initializer_list<std::uint8_t>{1, 2, 11, 12, 13, 14}) {
      AxisNodeConfig made = axis;
      made.node = number;
      made.absolute = number > 10;
      ports_.push_back(&stub_.attach("axis " + std::to_string(number)));
      nodes_.push_back(std::make_unique<AxisNode>(made, *ports_.back()));
    }
    // 20 turns a metre: 5 m/s^2 of the motor, 0.5 m/s^2 of friction.
    for (std::size_t k = 0; k < kAxes; ++k)
      motors_.emplace_back(DriveAxisConfig{.motor_s2 = 100.0, .friction_s2 = 10.0}, k == 2 ? 3.0 : 0.0);
    restart(config);
  }

  void restart(const drivers::odrive::UgvAxesConfig& config = {}) {
    drive_asks_.begin_anew();
    flippers_ask_.begin_anew();
    axes_ = std::make_unique<drivers::odrive::UgvAxes>(config);
    alive_ = true;
  }
  void kill() { alive_ = false; }

  /// Lets `ms` milliseconds pass; commands are renewed in each.
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ += kMs;
      drivers::CanFrame frame;
      if (alive_) {
        while (port_->receive(frame) == Status::ok) static_cast<void>(axes_->take(frame, now_));
        if (commands_) command();
        axes_->poll(now_, *port_);
      }
      for (std::size_t k = 0; k < kAxes; ++k) {
        motors_[k].advance(nodes_[k]->wish(), 1e-3);
        nodes_[k]->show(motor(k));
        while (ports_[k]->receive(frame) == Status::ok) nodes_[k]->hear(frame, now_);
        nodes_[k]->step(now_);
        fastest_ = std::max(fastest_, std::fabs(motors_[k].speed()));
      }
      stub_.advance(now_);
      while (listener_->receive(frame) == Status::ok) seen_.push_back(frame);
    }
  }

  /// All axes set up, then armed until they run.
  bool bring_up() {
    armed_ = false;
    run(3000);
    armed_ = true;
    run(600);
    return axes().running() && all_under_torque();
  }
  bool all_under_torque() const {
    return std::all_of(nodes_.begin(), nodes_.end(), [](const auto& node) { return node->command().on; });
  }
  bool none_under_torque() const {
    return std::none_of(nodes_.begin(), nodes_.end(), [](const auto& node) { return node->command().on; });
  }

  drivers::odrive::UgvAxes& axes() { return *axes_; }
  const drivers::odrive::Axis& axis(std::size_t i) const { return axes_->line().axis(i); }
  AxisNode& node(std::size_t i) { return *nodes_[i]; }
  AxisMotorState motor(std::size_t i) const { return {motors_[i].position(), motors_[i].speed(), 0.0}; }
  DriveAxis& plant(std::size_t i) { return motors_[i]; }
  drivers::CanStub& stub() { return stub_; }
  drivers::CanBus& listener() { return *listener_; }
  drivers::CanBus& group_port() { return *port_; }
  drivers::CanBus& port(std::size_t i) { return *ports_[i]; }
  const std::vector<drivers::CanFrame>& seen() const { return seen_; }
  /// The fastest of all motors since the last call.
  double fastest() { return std::exchange(fastest_, 0.0); }

  /// Turns a second of the tracks, turns of the first flipper; the others stay at 0.
  std::vector<double> targets_{5.0, -3.0, 4.0};
  bool armed_{};
  bool commands_{true};

 private:
  void command() {
    rt::DriveCommand drive;
    drive.stamp_ns = now_;
    drive.left_m_s = targets_[0] / 20.0;
    drive.right_m_s = targets_[1] / 20.0;
    rt::FlipperCommand flippers;
    flippers.stamp_ns = now_;
    flippers.angle_rad[0] = targets_[2] / 16.0;
    drive.flags = flippers.flags = armed_ ? 1u : 0u;
    drive_asks_(drive);
    flippers_ask_(flippers);
    // Finite, and of this moment.
    static_cast<void>(axes_->set(drive, now_));
    static_cast<void>(axes_->set(flippers, now_));
  }

  Asker drive_asks_, flippers_ask_;
  drivers::CanStub stub_{drivers::CanStubConfig{}};
  drivers::CanBus* port_;
  drivers::CanBus* listener_;
  std::vector<drivers::CanBus*> ports_;
  std::vector<std::unique_ptr<AxisNode>> nodes_;
  std::vector<DriveAxis> motors_;
  std::unique_ptr<drivers::odrive::UgvAxes> axes_;
  std::vector<drivers::CanFrame> seen_;
  rt::Nanoseconds now_{};
  double fastest_{};
  bool alive_{};
};

}  // namespace sortie::hil::test
