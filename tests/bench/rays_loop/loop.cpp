// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/rays_loop/loop.hpp"

#include <cmath>
#include <stdexcept>

#include "hil/ssl_sensor.hpp"
#include "mapping/occupancy/voxel_walk.hpp"

namespace sortie::bench {

namespace {

constexpr double kRange_m = rt::kSslMaxRange_m;
constexpr double kFrame_s = 0.02;  // of the sensor
constexpr std::int32_t kUnseen = INT32_MIN;

// Built worlds have their floors and walls at round numbers, on the very faces of the map's cells, where a
// micrometre decides. The map's frame is moved off that.
constexpr rt::Vector3 kMapOffset{0.07, 0.11, 0.09};

mapping::SensorPose map_pose(const LoopWorld& world, double t_s) {
  mapping::SensorPose pose = world.pose(t_s);
  pose.p_world_sensor_m = pose.p_world_sensor_m + kMapOffset;
  return pose;
}

struct LoopMap {
  std::vector<std::int8_t> cells;
  mapping::OccupancyMap map;
  explicit LoopMap(const rt::Vector3& middle)
      : cells(static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(loop_map_config()))),
        map(loop_map_config(), cells) {
    if (map.centre_on(middle) != Status::ok) throw std::runtime_error("the way leads nowhere");
  }
};

hil::Motion motion_at(const LoopWorld& world, double t_s) {
  const mapping::SensorPose pose = world.pose(t_s);
  hil::Motion motion;
  motion.stamp_ns = static_cast<rt::Nanoseconds>(std::llround(1e9 * t_s));
  motion.p_world_body_m = {pose.p_world_sensor_m.x, pose.p_world_sensor_m.y, pose.p_world_sensor_m.z};
  motion.q_world_body = {pose.q_world_sensor.w, pose.q_world_sensor.x, pose.q_world_sensor.y,
                         pose.q_world_sensor.z};
  return motion;
}

// The weighted log-loss of the paper: each class has half of the weight, cells that nobody can see have none.
void judge(const mapping::OccupancyView& view, const std::vector<std::uint8_t>& truth, double prior,
           double rays, LoopResult& result) {
  double penalty[256];  // of a cell that is occupied; of a free one it is that of the odds turned round
  double turned[256];
  for (int code = 0; code < 256; ++code) {
    const auto cell = static_cast<std::int8_t>(code < 128 ? code : code - 256);
    const double odds =
        cell == mapping::kUnknownCell ? std::log(prior / (1 - prior)) : mapping::kLogOddsStep * cell;
    penalty[code] = std::log1p(std::exp(-odds));
    turned[code] = std::log1p(std::exp(odds));
  }
  double sums[2]{};
  double counts[2]{};
  double found = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] == 0) continue;
    const std::uint32_t code = mapping::cell_code(view.cells[i]);
    const bool occupied = truth[i] == 2;
    sums[occupied ? 1 : 0] += occupied ? penalty[code] : turned[code];
    counts[occupied ? 1 : 0] += 1;
    if (occupied && view.cells[i] > 0) found += 1;
  }
  result.loss.push_back(0.5 * sums[0] / std::fmax(1, counts[0]) + 0.5 * sums[1] / std::fmax(1, counts[1]));
  result.found.push_back(found / rays);
}

}  // namespace

mapping::OccupancyConfig loop_map_config() {
  mapping::OccupancyConfig config;
  for (double& share : config.anchor) share = 0.5;
  config.roll_cells = 1;
  return config;
}

std::vector<std::uint8_t> loop_truth(const LoopWorld& world, const LoopSize& size) {
  const LoopMap frame(map_pose(world, 0).p_world_sensor_m);
  const mapping::OccupancyView view = frame.map.view();
  std::vector<std::int32_t> sums(frame.cells.size(), kUnseen);
  const auto note = [&sums](std::uint32_t cell, std::int32_t by) {
    sums[cell] = (sums[cell] == kUnseen ? 0 : sums[cell]) + by;
  };
  const hil::RayCaster caster = world.caster();
  std::vector<rt::Vector3> directions(rt::kSslDirections);
  for (std::uint32_t i = 0; i < rt::kSslDirections; ++i) directions[i] = rt::ssl_direction(i);
  for (int frame_number = 0; frame_number < size.frames; ++frame_number) {
    const hil::Motion motion = motion_at(world, size.period_s * frame_number + 0.5 * kFrame_s);
    hil::RayCaster::Aim aim;
    if (caster.aim({}, {motion.p_world_body_m, motion.q_world_body, {}}, aim) != Status::ok) continue;
    const mapping::SensorPose pose = map_pose(world, size.period_s * frame_number + 0.5 * kFrame_s);
    const rt::Vector3 from = pose.p_world_sensor_m;
    const rt::Quaternion q = pose.q_world_sensor;
    for (const rt::Vector3& v : directions) {
      const hil::RangeHit hit = caster.cast(aim, {v.x, v.y, v.z}, kRange_m);
      const rt::Vector3 way = rt::rotate(q, v);
      mapping::VoxelWalk walk = make_walk(view, view.to_window(from), way, hit.range_m / view.voxel_size_m);
      const rt::Vector3 end = view.to_window(from + hit.range_m * way);
      const bool seen = hit && view.contains(end);
      const std::uint32_t last =
          seen ? (static_cast<std::uint32_t>(end.z) * static_cast<std::uint32_t>(view.size[1]) +
                  static_cast<std::uint32_t>(end.y)) *
                         static_cast<std::uint32_t>(view.size[0]) +
                     static_cast<std::uint32_t>(end.x)
               : UINT32_MAX;
      do {
        if (walk.index != last) note(walk.index, -1);
      } while (walk.step());
      if (seen) note(last, 2);
    }
  }
  std::vector<std::uint8_t> truth(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i)
    truth[i] = static_cast<std::uint8_t>(sums[i] == kUnseen ? 0 : sums[i] >= 2 ? 2 : 1);
  return truth;
}

LoopResult run_loop(const LoopWorld& world, const std::vector<std::uint8_t>& truth, const LoopArm& arm,
                    const LoopSize& size, std::uint64_t seed) {
  LoopMap map(map_pose(world, 0).p_world_sensor_m);
  planner::SslChoiceConfig config = arm.choice;
  config.seed = seed;
  config.scheduler.rays = size.rays;
  std::vector<std::byte> memory(static_cast<std::size_t>(planner::SslChoice::memory_bytes(config)));
  planner::SslChoice choice(config, memory);
  if (!choice.usable()) throw std::runtime_error(arm.name + ": the settings are not usable");
  hil::SslConfig device;
  device.enabled = true;
  device.frame_ns = std::llround(1e9 * kFrame_s);
  for (double& place : device.mount_m) place = 0;
  hil::SslSensor sensor(device, {}, seed, 0);
  drivers::SslStub link;
  const hil::RayCaster caster = world.caster();
  LoopResult result;
  for (int frame = 0; frame < size.frames; ++frame) {
    const double now_s = size.period_s * frame;
    std::vector<mapping::SensorPose> poses;
    for (std::uint32_t i = 0; i < config.scheduler.positions; ++i)
      poses.push_back(map_pose(world, now_s + i * size.period_s + 0.5 * kFrame_s));
    static_cast<void>(choice.begin(map.map.view(), poses, 1));
    static_cast<void>(choice.step(arm.units));
    rt::SslCommand command;
    choice.choose(std::llround(1e9 * now_s), command);
    hil::SensorStep step;
    step.before = motion_at(world, now_s);
    step.after = motion_at(world, now_s + kFrame_s);
    rt::SslReturns returns;
    if (link.send(command) != Status::ok) throw std::runtime_error(arm.name + ": a command was refused");
    sensor.advance(caster, step, link);
    if (link.receive(returns) != Status::ok) throw std::runtime_error(arm.name + ": no answer");
    for (std::uint32_t i = 0; i < returns.rays; ++i) {
      const mapping::SensorPose pose =
          map_pose(world, 1e-9 * static_cast<double>(returns.stamp_ns) - 1e-5 * returns.age_10us[i]);
      const bool hit = returns.range_mm[i] > 0;
      const double range_m = hit ? rt::kSslRangeStep_m * returns.range_mm[i] : kRange_m;
      const rt::Vector3 way = rt::rotate(pose.q_world_sensor, rt::ssl_direction(returns.direction[i]));
      static_cast<void>(
          map.map.update_ray(pose.p_world_sensor_m, pose.p_world_sensor_m + range_m * way, hit));
    }
    judge(map.map.view(), truth, map.map.config().prior, 1.0 * size.rays * (frame + 1), result);
  }
  result.unplanned = static_cast<int>(choice.unplanned());
  return result;
}

}  // namespace sortie::bench
