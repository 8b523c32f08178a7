// SPDX-License-Identifier: BSD-3-Clause
// A robot that stands still before a wall with a solid-state lidar that answers late, twice, or not at all.
#pragma once

#include <memory>
#include <vector>

#include "drivers/ssl_port.hpp"
#include "firmware_like/live/simulated_robot.hpp"
#include "firmware_like/parts/ugv_ssl.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {

inline constexpr double kSslWall_m = 4.0;

/// An answer on its way, and when it comes.
struct SslAnswer {
  rt::Nanoseconds at{};
  rt::SslReturns returns;
};

/// What a wall across the x axis answers, and nothing where the ray goes elsewhere or farther than 12 m.
inline rt::SslReturns answer_of_wall(const rt::SslCommand& command, rt::Nanoseconds stamp_ns) {
  rt::SslReturns returns;
  returns.stamp_ns = stamp_ns;
  returns.number = command.number;
  returns.rays = command.rays;
  for (std::uint32_t i = 0; i < command.rays; ++i) {
    const double x = rt::ssl_direction(command.direction[i]).x;
    returns.direction[i] = command.direction[i];
    returns.range_mm[i] =
        static_cast<std::uint16_t>(kSslWall_m < 12.0 * x ? 1000.0 * kSslWall_m / x + 0.5 : 0.0);
    returns.age_10us[i] = static_cast<std::uint16_t>(10 * (command.rays - i));
  }
  return returns;
}

/// What went over the link.
struct SslTraffic {
  std::vector<rt::SslCommand> commands;
  std::vector<SslAnswer> answers;  ///< in the order in which they came
};

/// The device's link: every seventh answers by a fault of its own.
class FaultySslPort final : public drivers::SslPort {
 public:
  explicit FaultySslPort(SslTraffic& traffic) : traffic_(traffic) {}
  void set_time(rt::Nanoseconds now) { now_ = now; }
  Status send(const rt::SslCommand& command) noexcept override {
    if (!drivers::can_be_fired(command)) return Status::out_of_range;
    traffic_.commands.push_back(command);
    SslAnswer answer{now_ + 20'000'000, answer_of_wall(command, now_ + 20'000'000)};
    const std::uint32_t kind = command.number % 7;
    if (kind == 3) return Status::ok;         // lost
    if (kind == 4) answer.at += 130'000'000;  // overtaken by the next one
    pending_.push_back(answer);
    if (kind == 5) pending_.push_back(answer);  // twice
    if (kind == 6) {                            // of a command that nobody gave
      answer.returns.number += 1000;
      pending_.push_back(answer);
    }
    return Status::ok;
  }
  Status receive(rt::SslReturns& returns) noexcept override {
    for (auto it = pending_.begin(); it != pending_.end(); ++it) {
      if (it->at > now_) continue;
      returns = it->returns;
      traffic_.answers.push_back(*it);
      pending_.erase(it);
      return Status::ok;
    }
    return Status::empty;
  }

 private:
  SslTraffic& traffic_;
  std::vector<SslAnswer> pending_;
  rt::Nanoseconds now_{};
};

/// A bench that has this link alone.
class SslBench final : public firmware::SimulatedRobot {
 public:
  explicit SslBench(SslTraffic& traffic) : port_(traffic) {}
  void step(rt::Nanoseconds now_ns) override { port_.set_time(now_ns); }
  drivers::CanBus* vehicle_can() override { return nullptr; }
  drivers::SslPort* vehicle_ssl() override { return &port_; }

 private:
  FaultySslPort port_;
};

/// Stands at one place from the first job on, and says so.
class StandingVehicle final : public firmware::Vehicle {
 public:
  explicit StandingVehicle(firmware::VehicleBuilder& builder) {
    const rt::GroupId control = builder.group("control", 1000);
    rt::Task<rt::PoseEstimate>* pose = builder.task<rt::PoseEstimate>(
        control, "pose", 20, [](rt::JobContext& context, rt::PoseEstimate& output) {
          output = place();
          output.stamp_ns = context.release_ns;
        });
    builder.remembers(pose);
    builder.offer(*pose);
    ssl_ = firmware::make_ssl(builder);
    builder.check();
  }
  void poll_devices(const firmware::Devices& devices, rt::Nanoseconds now_ns) override {
    ssl_->poll_devices(devices, now_ns);
  }
  static rt::PoseEstimate place() {
    rt::PoseEstimate pose;
    pose.p_world_body_m[0] = 0.31;
    pose.p_world_body_m[1] = -0.17;
    return pose;
  }

 private:
  std::unique_ptr<firmware::Part> ssl_;
};

inline firmware::VehicleRegistry standing_vehicles() {
  return {{"standing", [](firmware::VehicleBuilder& builder) -> std::unique_ptr<firmware::Vehicle> {
             return std::make_unique<StandingVehicle>(builder);
           }}};
}

/// The scene of the standing vehicle, written into a folder.
inline std::string standing_scene(const TempFolder& folder) {
  return folder.write("standing.toml",
                      "[scene]\nname = \"standing\"\nvehicle = \"standing\"\n"
                      "[tasks]\nssl = { units = 400000 }\n"
                      "[ssl]\nrays = 50\npositions = 3\nrange_m = 12\n"
                      "[occupancy]\nwindow_x_m = 19.2\nwindow_y_m = 12.8\nwindow_z_m = 3.2\n"
                      "max_range_m = 12\nsilent_free_m = 12\n");
}

}  // namespace sortie::testing
