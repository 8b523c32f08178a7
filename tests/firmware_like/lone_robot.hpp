// SPDX-License-Identifier: BSD-3-Clause
// A desk, its stream and who obeys, without a run around them: the test decides when each of them moves.
#pragma once

#include <optional>
#include <vector>

#include "planner/uav_pilot.hpp"
#include "planner/ugv_drive.hpp"
#include "tests/firmware_like/request_rig.hpp"

namespace sortie::testing {

/// The stream between a desk and who obeys, as the runtime has it: 16 wait, 8 are taken by a job.
template <class Message>
struct LoneDesk {
  using Request = typename firmware::RequestKind<Message>::Request;
  explicit LoneDesk(const planner::RequestRules& rules) : desk({&port, rules}) {}

  std::vector<Request> ring = std::vector<Request>(16);
  std::vector<Request> batch = std::vector<Request>(8);
  rt::Stream<Request> stream{"requests", 0, ring.data(), 16, batch.data(), 8};
  firmware::InputPort<Request> port{"REQUESTS", stream};
  firmware::RequestDesk<Message> desk;
  rt::Tick tick{};
  template <class Obey>
  void job(Obey obey) {
    rt::StreamRange range;
    stream.latch(++tick, 8, range);
    for (const Request& request : stream) obey(request);
  }
};

/// A drive that would go on with its route, and a desk before it.
struct LoneDrive {
  using Message = drivers::DriveRequestMessage;
  LoneDrive() {
    planner::UgvDriveConfig config;
    config.icr = planner::IcrModel::from_efficiency(0.4, 1.0);
    drive.emplace(config);
    const planner::Waypoint far[] = {{1000, 0}};
    REQUIRE(drive->set_route(far) == Status::ok);
  }
  static Message move() {
    Message message;
    message.speed_m_s = 0.3;
    return message;
  }
  static Message with_mode(rt::DriveMode mode) {
    Message message;
    message.mode = static_cast<std::uint32_t>(mode);
    return message;
  }
  static Message stop() { return with_mode(rt::DriveMode::halt); }
  static Message release() { return with_mode(rt::DriveMode::release); }
  void job(rt::Nanoseconds now_ns) {
    lone.job([&](const rt::DriveRequest& request) { static_cast<void>(drive->request(request, now_ns)); });
    rt::PoseEstimate pose;
    pose.stamp_ns = now_ns;
    pose.flags = 1;
    REQUIRE(drive->update(pose, {}, now_ns) == Status::ok);
  }
  bool is_stopped() const { return (drive->output().stop & planner::kStopHalt) != 0; }
  std::int64_t newest() const { return drive->output().request_counter; }

  LoneDesk<Message> lone{{0, 300 * rt::kNanosecondsPerMillisecond}};
  std::optional<planner::UgvDrive> drive;
};

/// A pilot whose vehicle has no position yet, and a desk before it.
struct LonePilot {
  using Message = drivers::FlyRequestMessage;
  static Message with_mode(rt::FlyMode mode) {
    Message message;
    message.p_world_m[0] = 3;
    message.mode = static_cast<std::uint32_t>(mode);
    return message;
  }
  static Message move() { return with_mode(rt::FlyMode::go); }
  static Message stop() { return with_mode(rt::FlyMode::stop); }
  static Message release() { return with_mode(rt::FlyMode::release); }
  void job(rt::Nanoseconds now_ns) {
    lone.job([&](const rt::FlyRequest& request) { static_cast<void>(pilot->request(request, now_ns)); });
    rt::UavState state;
    state.stamp_ns = now_ns;
    state.verdict = rt::UavVerdict::dead;
    pilot->update(state, nullptr, now_ns);
  }
  bool is_stopped() const {
    return pilot->output().step == static_cast<std::uint32_t>(planner::PilotStep::stopped) &&
           pilot->output().remote != 0;
  }
  std::int64_t newest() const { return pilot->output().request_counter; }

  LoneDesk<Message> lone{{0, planner::kMostFlyRequestAge_ns}};
  std::optional<planner::UavPilot> pilot{std::in_place, planner::UavPilotConfig{}};
};

}  // namespace sortie::testing
