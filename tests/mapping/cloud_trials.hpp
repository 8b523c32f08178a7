// SPDX-License-Identifier: BSD-3-Clause
// Clouds of air and ground with their cells and lines of sight, true ones and false ones, and what the
// registration of clouds makes of them.
#pragma once

#include <memory>

#include "mapping/registration/cloud_match.hpp"
#include "rt/arena.hpp"
#include "tests/mapping/air_ground_trials.hpp"

namespace sortie::tests {

/// A layer with memory of its own.
struct OwnedSight {
  explicit OwnedSight(const mapping::SightConfig& config)
      : memory(bytes_of(config)), arena(memory), layer(config, arena) {}
  static std::size_t bytes_of(const mapping::SightConfig& config) {
    rt::Arena measured({});
    const mapping::SightLayer none(config, measured);
    return static_cast<std::size_t>(measured.needed_bytes());
  }
  void fill(const std::vector<SeenPoint>& cloud, std::uint32_t most = mapping::SightConfig{}.points) {
    layer.clear();
    std::vector<rt::Vector3> view;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      view.push_back(cloud[i].at_m);
      const bool last = i + 1 == cloud.size() || rt::norm(cloud[i + 1].from_m - cloud[i].from_m) > 0.0;
      if (!last && view.size() < most) continue;
      full = full || layer.insert(view, cloud[i].from_m) != Status::ok;
      view.clear();
    }
    layer.prepare();
  }

  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::SightLayer layer;
  bool full{};
};

/// Layers and registration, used for one scene after the other.
struct CloudRig {
  explicit CloudRig(const mapping::CloudRegistrationConfig& config = {})
      : registration(std::make_unique<mapping::CloudRegistration>(config)) {}
  Status begin(const AirGroundScene& scene, const mapping::PlaneEstimate& estimate) {
    air.fill(scene.air);
    ground.fill(scene.ground);
    return registration->begin(scene.scene.source, air.layer, scene.scene.target, ground.layer, estimate);
  }
  const mapping::CloudResult& run(const AirGroundScene& scene, const mapping::PlaneEstimate& estimate) {
    std::uint64_t units = std::uint64_t{1} << 60;
    if (begin(scene, estimate) == Status::ok) (void)registration->run(units);
    return registration->result();
  }

  OwnedSight air{mapping::sight_config(mapping::CloudSensor::camera)};
  OwnedSight ground{mapping::sight_config(mapping::CloudSensor::laser)};
  std::unique_ptr<mapping::CloudRegistration> registration;
};

/// The same as the robots have it: planes from the clouds' cells, and grids of wider ones.
struct CloudMatchRig {
  /// `times`: how much wider the cells of both are than usual.
  explicit CloudMatchRig(const mapping::CloudMatchConfig& with = {}, double times = 1.0)
      : config(with),
        air(usual(mapping::CloudSensor::camera, times)),
        ground(usual(mapping::CloudSensor::laser, times)) {}
  static mapping::SightConfig usual(mapping::CloudSensor sensor, double times) {
    mapping::SightConfig sight = mapping::sight_config(sensor);
    sight.cell_m *= times;
    return sight;
  }
  void begin(const AirGroundScene& scene, const mapping::PlaneEstimate& estimate) {
    air.fill(scene.air);
    ground.fill(scene.ground);
    mapping::SensedCloud own{&air.layer, mapping::CloudSensor::camera};
    mapping::SensedCloud kept{&ground.layer, mapping::CloudSensor::laser};
    if (swapped) std::swap(own, kept);
    match.reset();
    if (memory.empty()) {
      rt::Arena measured({});
      (void)std::make_unique<mapping::CloudMatch>(config, own, kept, measured);
      memory.resize(static_cast<std::size_t>(measured.needed_bytes()));
    }
    rt::Arena arena(memory);
    match = std::make_unique<mapping::CloudMatch>(config, own, kept, arena);
    match->begin(estimate);
  }
  const mapping::CloudResult& run(const AirGroundScene& scene, const mapping::PlaneEstimate& estimate) {
    begin(scene, estimate);
    std::uint64_t units = std::uint64_t{1} << 60;
    (void)match->run(units);
    return match->result();
  }

  mapping::CloudMatchConfig config;
  OwnedSight air;
  OwnedSight ground;
  bool swapped{};  ///< the ground's is the own cloud, and the estimate is of it
  std::vector<std::byte> memory;
  std::unique_ptr<mapping::CloudMatch> match;
};

/// The mirror image of a building, in the same place.
inline Building mirror_image(Building out) {
  for (SolidBox& box : out.boxes) {
    box.middle_m.x = out.size_m.x - box.middle_m.x;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if ((i == 0) != (j == 0)) box.turn.m[3 * i + j] = -box.turn.m[3 * i + j];
      }
    }
  }
  return out;
}

/// A building that looks the same from both ends, but for one thing in `odd`.
inline Building from_both_ends(Building out, std::uint32_t odd, WorldRandom& random) {
  const std::size_t count = out.boxes.size();
  for (std::size_t k = 1; k < count; ++k) {
    if (random.below(odd) == 0) continue;
    SolidBox box = out.boxes[k];
    box.middle_m.x = out.size_m.x - box.middle_m.x;
    box.middle_m.y = out.size_m.y - box.middle_m.y;
    for (int i = 0; i < 6; ++i) box.turn.m[i] = -box.turn.m[i];
    out.boxes.push_back(box);
  }
  return out;
}

/// 0: a building; 1: one that looks nearly the same from both ends; 2: the air sees its mirror image; 3: the
/// air sees another building.
inline AirGroundScene cloud_scene(int kind, WorldRandom& random) {
  Building in = random_building(random);
  if (kind == 1) in = from_both_ends(in, 6, random);
  const Building above = kind == 2 ? mirror_image(in) : kind == 3 ? random_building(random) : in;
  return scene_of(in, above, 0.8, 0.2, random);
}

/// What became of a scene. `nowhere`: any place is wrong.
inline void judge(AirGroundTally& tally, const AirGroundScene& scene, const mapping::CloudResult& result,
                  bool nowhere) {
  ++tally.scenes;
  if (!result.placed()) {
    ++tally.tally.refused;
    return;
  }
  const PoseError e = pose_error(scene.scene, result.T_target_source);
  tally.position_m.push_back(e.position_m), tally.angle_rad.push_back(e.angle_rad);
  tally.scale.push_back(e.scale);
  tally.tally.count(e, nowhere);
}

/// Tallies of scenes of a kind, by bin_of(); `known`: to 3 m and 6 degrees.
struct CloudRuns {
  AirGroundTally of[5];
  std::vector<double> units;

  std::uint32_t wrong() const {
    std::uint32_t sum = 0;
    for (const AirGroundTally& t : of) sum += t.tally.wrong;
    return sum;
  }
  std::uint32_t placed() const {
    std::uint32_t sum = 0;
    for (const AirGroundTally& t : of) sum += t.tally.close;
    return sum;
  }
};

inline CloudRuns cloud_trials(int kind, bool known, std::uint32_t seed, std::uint32_t trials,
                              const mapping::CloudMatchConfig& config = {}) {
  CloudMatchRig rig(config);
  CloudRuns out;
  for (std::uint32_t i = 0; i < trials; ++i) {
    WorldRandom random(seed + i);
    const AirGroundScene scene = cloud_scene(kind, random);
    const mapping::CloudResult& result = rig.run(scene, gps(scene.scene, known, 0.05, random));
    judge(out.of[kind < 2 ? bin_of(scene) : 4], scene, result, kind >= 2);
    out.units.push_back(static_cast<double>(result.units));
  }
  return out;
}

}  // namespace sortie::tests
