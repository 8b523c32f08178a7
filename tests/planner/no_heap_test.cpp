// SPDX-License-Identifier: BSD-3-Clause
// The drive, the flippers, their policy and postures take no memory from the heap.
#include <catch2/catch.hpp>
#include <memory>

#include "planner/flipper_policy.hpp"
#include "planner/flipper_postures.hpp"
#include "planner/posture_bounds.hpp"
#include "planner/ugv_drive.hpp"
#include "rt/posix/heap_trap.hpp"

TEST_CASE("The drive and the flippers make no heap call after construction") {
  using namespace sortie;
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  planner::UgvDrive drive(planner::UgvDriveConfig{});
  planner::FlipperPostures flippers;
  const planner::Waypoint route[] = {{1, 0}, {1, 1}, {0, 0}};
  const planner::MissionStep steps[] = {{0, 0.2, 0.1, 0, false}, {500'000'000, 0, 0, -1, true}};
  const planner::FlipperPosture postures[] = {{{0, 0, 0, 0}}, {{1, 1, 1, 1}}};
  std::uint64_t calls = 0;
  bool good = true;
  {
    const rt::posix::HeapTrapScope scope;
    good = drive.set_route(route) == Status::ok && drive.set_mission(steps) == Status::ok &&
           flippers.set_up(postures, {}) == Status::ok;
    rt::PoseEstimate pose;
    pose.flags = 1;
    for (int i = 1; i < 1000; ++i) {
      pose.stamp_ns = i * rt::kNanosecondsPerMillisecond;
      pose.p_world_body_m[0] = 0.002 * i;
      rt::DriveRequest request;
      request.stamp_ns = pose.stamp_ns;
      request.counter = i;
      request.speed_m_s = 0.3;
      request.mode = static_cast<std::uint32_t>(i % 3);
      good = good && (i < 800 || drive.request(request, request.stamp_ns) == Status::ok);
      good = good && drive.update(pose, {i % 100 == 0, false}, pose.stamp_ns) == Status::ok;
      good = good && flippers.update(i % 2, false, pose.stamp_ns) == Status::ok;
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(good);
}

TEST_CASE("Postures and their bounds make no heap call after construction") {
  using namespace sortie;
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  const planner::HeightView steps{nullptr,
                                  [](const void*, std::int64_t i, std::int64_t j) {
                                    const double high = i % 7 == 0 && j % 3 != 0 ? 0.1 : 0.0;
                                    return planner::HeightCell{0.0, high, planner::HeightState::known};
                                  },
                                  0.05};
  const auto solver =
      std::make_unique<planner::PostureSolver>(planner::PostureVehicle{}, planner::PostureConfig{});
  const auto bounder = std::make_unique<planner::PostureBounder>();
  std::uint64_t calls = 0;
  bool good = true;
  {
    const rt::posix::HeapTrapScope scope;
    for (int i = 0; i < 20; ++i) {
      planner::Posture posture;
      planner::PostureBounds bounds;
      const planner::FlipperSet flippers{{0.1 * i, 0.05 * i, -0.02 * i, 0.3}};
      good = good && solver->look(steps, {0.03 * i, 0.0, 0.3 * i}) == Status::ok &&
             solver->rest(flippers, posture) == Status::ok &&
             bounder->bound(*solver, flippers, 512, bounds) == Status::ok;
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(good);
}

TEST_CASE("The flippers' policy makes no heap call after construction") {
  using namespace sortie;
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  // Blocks, and cells that are missing.
  const planner::HeightView blocks{nullptr,
                                   [](const void*, std::int64_t i, std::int64_t j) {
                                     if ((i * 3 + j) % 5 == 0) return planner::HeightCell{};
                                     const double high = i % 7 == 0 && j % 3 != 0 ? 0.1 : 0.0;
                                     return planner::HeightCell{0.0, high, planner::HeightState::known};
                                   },
                                   0.05};
  const auto policy =
      std::make_unique<planner::FlipperPolicy>(planner::PostureVehicle{}, planner::FlipperPolicyConfig{});
  std::uint64_t calls = 0;
  bool good = true;
  {
    const rt::posix::HeapTrapScope scope;
    for (int i = 1; i < 20; ++i) {
      planner::FlipperInput in;
      in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = i * rt::kNanosecondsPerSecond;
      in.pose = {0.03 * i, 0.0, 0.3 * i};
      in.arc = {0.2, 0.1};
      in.z_m = 0.1;
      planner::FlipperDecision decision;
      good = good && policy->decide(blocks, in, decision) == Status::ok;
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(good);
}
