// SPDX-License-Identifier: BSD-3-Clause
// Who chooses the rays of a solid-state lidar: each policy gives a command that can be fired, and the
// scheduler's is its plan for the next position.
#include "planner/ssl_choice.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "drivers/ssl_port.hpp"
#include "planner/ssl_horizon.hpp"
#include "tests/planner/ray_scenes.hpp"

namespace {

using namespace sortie::planner;
namespace mapping = sortie::mapping;
namespace rt = sortie::rt;
using sortie::Status;

mapping::OccupancyConfig choice_map_config() {
  mapping::OccupancyConfig config;
  config.size[0] = config.size[1] = 64;
  config.size[2] = 16;
  config.anchor[0] = 0.5;
  return config;
}

SslChoiceConfig choice_config(SslPolicy policy, std::uint32_t rays = 50) {
  SslChoiceConfig config;
  config.policy = policy;
  config.scheduler.rays = rays;
  config.scheduler.positions = 2;
  config.scheduler.map_cells = 64 * 64 * 16;
  config.scheduler.sensor.range_m = 8;
  return config;
}

struct OwnedChoice {
  explicit OwnedChoice(const SslChoiceConfig& config)
      : memory(static_cast<std::size_t>(SslChoice::memory_bytes(config))), choice(config, memory) {}
  std::vector<std::byte> memory;
  SslChoice choice;
};

// All different, all in the grid, as many as they should be.
bool fires(const rt::SslCommand& command, std::uint32_t rays) {
  const std::set<std::uint16_t> all(command.direction, command.direction + command.rays);
  return command.rays == rays && all.size() == rays && sortie::drivers::can_be_fired(command);
}

bool same_rays(const rt::SslCommand& a, const rt::SslCommand& b) {
  return a.rays == b.rays && a.number == b.number &&
         std::equal(a.direction, a.direction + a.rays, b.direction);
}

const mapping::SensorPose kChoicePoses[2] = {{{0.05, 0.07, 0.1}, {}}, {{0.25, 0.07, 0.1}, {}}};

}  // namespace

TEST_CASE("Every policy gives commands that can be fired, numbered on, whatever the number of rays") {
  for (const SslPolicy policy :
       {SslPolicy::scheduled, SslPolicy::grid, SslPolicy::random, SslPolicy::stride}) {
    for (const std::uint32_t rays : {0u, 1u, 2u, 50u, 199u, 200u, 256u, 257u, 100'000u}) {
      OwnedChoice owned(choice_config(policy, rays));
      REQUIRE(owned.choice.usable());
      sortie::tests::RayMap map(choice_map_config());
      for (std::uint32_t number = 1; number <= 3; ++number) {
        REQUIRE(owned.choice.begin(map.map.view(), kChoicePoses, 1) == Status::ok);
        rt::SslCommand command;
        owned.choice.choose(77, command);
        CAPTURE(static_cast<int>(policy), rays, number);
        REQUIRE(command.number == number);
        REQUIRE(command.stamp_ns == 77);
        REQUIRE(fires(command, std::min(rays, 256u)));
      }
      CHECK(owned.choice.unplanned() == (policy == SslPolicy::scheduled ? 3 : 0));
    }
  }
}

TEST_CASE("Only the scheduler has memory, and without enough of it strides are asked for") {
  for (const SslPolicy policy : {SslPolicy::grid, SslPolicy::random, SslPolicy::stride})
    CHECK(SslChoice::memory_bytes(choice_config(policy)) == 0);
  const SslChoiceConfig config = choice_config(SslPolicy::scheduled);
  CHECK(SslChoice::memory_bytes(config) == RayScheduler::memory_bytes(config.scheduler));
  SslChoice poor(config, {});
  CHECK_FALSE(poor.usable());
  sortie::tests::RayMap map(choice_map_config());
  CHECK(poor.begin(map.map.view(), kChoicePoses, 1) == Status::out_of_range);
  CHECK(poor.step(1000) == 0);
  CHECK(poor.done());
  OwnedChoice strides(choice_config(SslPolicy::stride));
  for (int i = 0; i < 3; ++i) {
    rt::SslCommand a;
    rt::SslCommand b;
    poor.choose(0, a);
    strides.choice.choose(0, b);
    CHECK(same_rays(a, b));
  }
  CHECK(poor.unplanned() == 3);
  SslChoiceConfig other = config;
  other.scheduler.sensor.columns = 80;  // not the device's
  CHECK(SslChoice::memory_bytes(other) == 0);
  CHECK_FALSE(OwnedChoice(other).choice.usable());
}

TEST_CASE("What is asked for is the plan for the next position, also when nothing may be spent") {
  sortie::tests::RayMap map(choice_map_config());
  const SslChoiceConfig config = choice_config(SslPolicy::scheduled);
  OwnedChoice owned(config);
  sortie::tests::OwnedScheduler twin(config.scheduler);
  for (int job = 1; job < 13; ++job) {
    // The plan before reaches one command further.
    const std::uint64_t units = job % 4 == 0 ? 0 : 3'000'000u;
    const std::uint32_t passed = job % 2 == 0 ? 1 : 2;
    REQUIRE(owned.choice.begin(map.map.view(), kChoicePoses, passed) == Status::ok);
    REQUIRE(twin.scheduler.begin(map.map.view(), kChoicePoses, passed) == Status::ok);
    for (std::uint64_t spent = 0; spent < units; spent += 5000) (void)owned.choice.step(5000);
    (void)twin.scheduler.step(units);
    REQUIRE(owned.choice.plan() != nullptr);
    CHECK(owned.choice.plan()->digest == twin.scheduler.plan().digest);
    rt::SslCommand command;
    owned.choice.choose(0, command);
    const auto rays = twin.scheduler.rays(0);
    REQUIRE(command.rays == rays.size());
    CHECK(std::equal(rays.begin(), rays.end(), command.direction));
    for (const std::uint16_t ray : rays) {
      const rt::Vector3 way = rt::ssl_direction(ray);
      const rt::Vector3& from = kChoicePoses[0].p_world_sensor_m;
      (void)map.map.update_ray(from, from + 3.0 * way, ray % 3 != 0);
    }
  }
  CHECK(owned.choice.unplanned() == 0);
  // No pose: strides, and the next plan is as good as ever.
  const double nan = std::nan("");
  const mapping::SensorPose nowhere{{nan, 0, 0}, {}};
  CHECK(owned.choice.begin(map.map.view(), {&nowhere, 1}, 1) == Status::not_finite);
  CHECK(owned.choice.plan() == nullptr);
  rt::SslCommand command;
  owned.choice.choose(0, command);
  CHECK(fires(command, 50));
  CHECK(owned.choice.unplanned() == 1);
}

TEST_CASE("Without units strides are asked for when the last plan is used up, not one pattern for ever") {
  sortie::tests::RayMap map(choice_map_config());
  OwnedChoice owned(choice_config(SslPolicy::scheduled));
  REQUIRE(owned.choice.begin(map.map.view(), kChoicePoses, 1) == Status::ok);
  (void)owned.choice.step(3'000'000);
  std::set<std::vector<std::uint16_t>> commands;
  for (std::uint32_t job = 0; job < 20; ++job) {
    rt::SslCommand command;
    owned.choice.choose(0, command);
    REQUIRE(fires(command, 50));
    commands.insert({command.direction, command.direction + 50});
    CHECK(owned.choice.unplanned() == (job < 2 ? 0 : job - 1));
    REQUIRE(owned.choice.begin(map.map.view(), kChoicePoses, 1) == Status::ok);
  }
  CHECK(commands.size() == 20);
}

TEST_CASE("A grid is even, and chance is fair") {
  OwnedChoice grid(choice_config(SslPolicy::grid, 192));
  rt::SslCommand command;
  grid.choice.choose(0, command);
  int most = 0;
  for (int x = 0; x < 160; ++x) {
    for (int y = 0; y < 120; ++y) {
      int least = 1000;
      for (std::uint32_t i = 0; i < command.rays; ++i)
        least = std::min(least, std::max(std::abs(command.direction[i] % 160 - x),
                                         std::abs(command.direction[i] / 160 - y)));
      most = std::max(most, least);
    }
  }
  CHECK(most == 5);  // 16 x 12 cells of 10 x 10 directions
  OwnedChoice random(choice_config(SslPolicy::random, 200));
  SslChoiceConfig config = choice_config(SslPolicy::random, 200);
  config.seed = 2;
  OwnedChoice other(config);
  std::vector<int> counts(rt::kSslDirections);
  int same = 0;
  for (int n = 0; n < 2000; ++n) {
    random.choice.choose(0, command);
    for (std::uint32_t i = 0; i < command.rays; ++i) ++counts[command.direction[i]];
    rt::SslCommand second;
    other.choice.choose(0, second);
    same += same_rays(command, second) ? 1 : 0;
  }
  CHECK(same == 0);
  // Each direction is drawn with 200 / 19,200 a command: 20.8 times, and chi-square has its mean and spread.
  const double mean = 2000.0 * 200 / rt::kSslDirections;
  double chi2 = 0;
  for (const int count : counts) chi2 += (count - mean) * (count - mean) / (mean * (1 - 200.0 / 19200));
  const double freedom = rt::kSslDirections - 1.0;
  CHECK(std::fabs(chi2 - freedom) < 5 * std::sqrt(2 * freedom));
}

TEST_CASE("A choice goes on from its bytes as from where they were taken") {
  for (const SslPolicy policy : {SslPolicy::scheduled, SslPolicy::random, SslPolicy::stride}) {
    const SslChoiceConfig config = choice_config(policy);
    sortie::tests::RayMap map(choice_map_config());
    OwnedChoice owned(config);
    OwnedChoice restored(config);
    rt::SslCommand dirty;
    (void)restored.choice.begin(map.map.view(), {kChoicePoses + 1, 1}, 1);
    (void)restored.choice.step(100'000);
    restored.choice.choose(0, dirty);
    for (int job = 0; job < 6; ++job) {
      rt::Archive measure = rt::Archive::measuring();
      owned.choice.archive(measure);
      REQUIRE(measure.status() == Status::ok);
      std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
      rt::Archive write = rt::Archive::writing(bytes);
      owned.choice.archive(write);
      rt::Archive read = rt::Archive::reading(bytes);
      restored.choice.archive(read);
      REQUIRE(read.status() == Status::ok);
      rt::SslCommand commands[2];
      for (int i = 0; i < 2; ++i) {
        SslChoice& choice = i == 0 ? owned.choice : restored.choice;
        REQUIRE(choice.begin(map.map.view(), kChoicePoses, 1) == Status::ok);
        (void)choice.step(job % 2 == 0 ? 3'000 : 3'000'000);
        choice.choose(job, commands[i]);
      }
      CHECK(same_rays(commands[0], commands[1]));
      for (std::uint32_t i = 0; i < commands[0].rays; ++i)
        (void)map.map.update_ray({0.05, 0.07, 0.1}, 4.0 * rt::ssl_direction(commands[0].direction[i]),
                                 i % 2 == 0);
    }
    if (policy != SslPolicy::scheduled) continue;
    // Bytes of another configuration, cut off, or with a direction that there is not.
    rt::Archive measure = rt::Archive::measuring();
    owned.choice.archive(measure);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
    rt::Archive write = rt::Archive::writing(bytes);
    owned.choice.archive(write);
    OwnedChoice fewer(choice_config(policy, 49));
    rt::Archive wrong = rt::Archive::reading(bytes);
    fewer.choice.archive(wrong);
    CHECK(wrong.status() == Status::malformed);
    rt::Archive cut = rt::Archive::reading(std::span<const std::uint8_t>(bytes).first(bytes.size() - 1));
    restored.choice.archive(cut);
    CHECK(cut.status() == Status::malformed);
    for (std::size_t i = bytes.size() - 4; i < bytes.size(); ++i) bytes[i] = 0xff;
    rt::Archive far = rt::Archive::reading(bytes);
    restored.choice.archive(far);
    CHECK(far.status() == Status::malformed);
  }
}

TEST_CASE("Where a body will be is where small steps along its arc lead") {
  for (const double turn : {0.0, 1e-6, 0.3, -1.1, 4.0}) {
    rt::PoseEstimate pose;
    rt::store(rt::Vector3{1, -2, 0.5}, pose.p_world_body_m);
    rt::store(rt::from_yaw_pitch_roll(0.7, -0.3, 0.1), pose.q_world_body);
    rt::store(rt::Vector3{0.8, 0.1, -0.05}, pose.v_body_m_s);
    // The rate that is purely about the vertical.
    const rt::Quaternion q0 = rt::to_quaternion(pose.q_world_body);
    rt::store(rt::rotate_back(q0, {0, 0, turn}), pose.w_body_rad_s);
    rt::Vector3 p = rt::to_vector(pose.p_world_body_m);
    rt::Quaternion q = q0;
    const int steps = 20'000;
    const double dt = 1.5 / steps;
    for (int i = 0; i < steps; ++i) {
      const rt::Quaternion middle = q * rt::exp_rotation(0.5 * dt * rt::to_vector(pose.w_body_rad_s));
      p = p + dt * rt::rotate(middle, rt::to_vector(pose.v_body_m_s));
      q = q * rt::exp_rotation(dt * rt::to_vector(pose.w_body_rad_s));
    }
    const mapping::SensorPose ahead = body_ahead(pose, 1.5);
    CHECK(rt::norm(ahead.p_world_sensor_m - p) < 1e-7);
    CHECK(rt::norm(rt::log_rotation(rt::conjugate(q) * ahead.q_world_sensor)) < 1e-7);
    const mapping::SensorPose now = body_ahead(pose, 0.0);
    CHECK(rt::norm(now.p_world_sensor_m - rt::to_vector(pose.p_world_body_m)) == 0.0);
  }
  // A pitching rate is not followed.
  rt::PoseEstimate pitching;
  pitching.w_body_rad_s[1] = 2.0;
  CHECK(rt::norm(rt::log_rotation(body_ahead(pitching, 0.5).q_world_sensor)) == 0.0);
}
