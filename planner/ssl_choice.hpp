// SPDX-License-Identifier: BSD-3-Clause
// Who says which rays a solid-state lidar fires next: the scheduler, or a pattern that knows no map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "planner/ray_scheduler.hpp"
#include "rt/archive.hpp"
#include "rt/keys.hpp"
#include "rt/ssl_samples.hpp"

namespace sortie::planner {

/// The golden section of the number of directions, and coprime to it: any K rays in a row are spread over the
/// whole field of view, and after kSslDirections rays each direction was asked for exactly once.
inline constexpr std::uint32_t kRayStride = 11'867;

/// What asks for the next rays where nothing better is known. Plain state, no heap.
class RayStride {
 public:
  /// The next `rays` (at most kSslMaxRays) directions. Commands are numbered from 1. Cost: 1 ns a ray.
  void next(std::uint32_t rays, rt::Nanoseconds stamp_ns, rt::SslCommand& command) {
    command = {};
    command.stamp_ns = stamp_ns;
    command.number = ++number_;
    command.rays = rays < rt::kSslMaxRays ? rays : rt::kSslMaxRays;
    for (std::uint32_t i = 0; i < command.rays; ++i) {
      command.direction[i] = static_cast<std::uint16_t>(direction_);
      direction_ = (direction_ + kRayStride) % rt::kSslDirections;
    }
  }

  SORTIE_FIELDS(direction_, number_)

 private:
  std::uint32_t direction_{};
  std::uint32_t number_{};
};

/// How rays are chosen.
enum class SslPolicy : std::uint8_t {
  scheduled,  ///< planner/ray_scheduler.hpp, over a map
  grid,       ///< the same even grid every time
  random,     ///< any, all different, by a generator that the command's number seeds
  stride,     ///< RayStride: every direction once before any twice
};

/// Settings. The sensor is the device's: kSslColumns by kSslRows directions.
struct SslChoiceConfig {
  SslPolicy policy{SslPolicy::scheduled};
  RaySchedulerConfig scheduler;  ///< its `rays` hold for every policy, at most kSslMaxRays
  std::uint64_t seed{1};         ///< of `random`

  SORTIE_KEYS(c, key) {
    key("policy", c.policy,
        {"who says which rays are fired: the scheduler over a map, the same even grid, chance, or strides "
         "through all directions",
         {{"scheduled", SslPolicy::scheduled},
          {"grid", SslPolicy::grid},
          {"random", SslPolicy::random},
          {"stride", SslPolicy::stride}}});
    key("rays", c.scheduler.rays, {1, rt::kSslMaxRays, "", "asked for at every release"});
    key("seed", c.seed, {0, 4294967295.0, "", "of rays that are chosen by chance"});
    key("positions", c.scheduler.positions,
        {1, RaySizes::kMostPositions, "", "releases that are planned together, the next one among them"});
    key("range_m", c.scheduler.sensor.range_m, {0.5, 65, "m", "rays are planned up to here"});
    key("unknown", c.scheduler.model.unknown,
        {"behind the first unknown cell a planned ray goes on with the prior, or ends",
         {{"prior", UnknownSpace::prior}, {"stop", UnknownSpace::stop}}});
  }
};

/// The next command, whatever the policy. Memory is the caller's, and only the scheduler has some; no heap.
/// What it does depends on its inputs and on the units spent alone.
class SslChoice {
 public:
  /// Bytes that a config asks for: 0 for every policy but `scheduled`, and for settings out of their range.
  static std::uint64_t memory_bytes(const SslChoiceConfig& config);
  SslChoice(const SslChoiceConfig& config, std::span<std::byte> memory);
  /// False when there is too little memory or a setting is out of its range: then nothing is planned, and
  /// choose() gives strides.
  bool usable() const { return usable_; }

  /// The poses of the sensor from which this command and the next ones are fired. `passed`: commands since
  /// the last begin() (see RayScheduler). Only `scheduled` looks at it. Status: ok; that of
  /// RayScheduler::begin(), and then choose() gives strides.
  Status begin(const mapping::OccupancyView& map, std::span<const mapping::SensorPose> poses,
               std::uint32_t passed);
  /// Spends at most `units`; returns what was spent. done(): more units change nothing.
  std::uint64_t step(std::uint64_t units);
  bool done() const { return !planning_ || scheduler_->done(); }
  /// The plan for this command; null where none was begun.
  const RayPlan* plan() const { return planning_ ? &scheduler_->plan() : nullptr; }

  /// min(K, kSslMaxRays) different rays, numbered on. The map may change again afterwards. Where too few
  /// units were spent for any stage, and no earlier plan reaches here, the scheduler's seed is the same
  /// pattern each time and would show nothing new: strides are asked for then.
  void choose(rt::Nanoseconds stamp_ns, rt::SslCommand& command);

  /// Commands that were to be scheduled, but had no plan.
  std::uint64_t unplanned() const { return unplanned_; }
  void archive(rt::Archive& archive);

 private:
  void fill_grid(rt::SslCommand& command) const;
  void fill_random(rt::SslCommand& command) const;

  SslChoiceConfig config_;
  std::optional<RayScheduler> scheduler_;
  RayStride stride_;
  std::uint32_t rays_{};
  std::uint32_t number_{};
  std::uint32_t planned_{};  // positions from the next one on that a stage has planned
  std::uint64_t unplanned_{};
  bool usable_{};
  bool planning_{};
};

}  // namespace sortie::planner
