// SPDX-License-Identifier: BSD-3-Clause
// From the two clouds of a building to the pose of one in the other: planes grown from both, then registered.
#pragma once

#include <array>
#include <cstdio>
#include <map>
#include <memory>

#include "mapping/registration/cloud_config.hpp"
#include "tests/mapping/air_ground_world.hpp"
#include "tests/mapping/plane_points.hpp"
#include "tests/mapping/plane_trials.hpp"

namespace sortie::tests {

/// Cells whose normals point to where their points were seen from.
inline std::vector<mapping::PlaneCell> signed_cells(const std::vector<SeenPoint>& cloud, double edge_m) {
  std::vector<Eigen::Vector3d> points;
  std::map<std::array<std::int32_t, 3>, rt::Vector3> toward;
  for (const SeenPoint& p : cloud) {
    points.emplace_back(p.at_m.x, p.at_m.y, p.at_m.z);
    std::array<std::int32_t, 3> at{};
    for (int i = 0; i < 3; ++i)
      at[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(std::floor(points.back()[i] / edge_m));
    rt::Vector3& sum = toward[at];
    const rt::Vector3 back = p.from_m - p.at_m;
    sum = sum + (1.0 / rt::norm(back)) * back;
  }
  std::vector<mapping::PlaneCell> cells = cells_of(points, edge_m);
  for (mapping::PlaneCell& cell : cells) {
    const rt::Vector3 back = toward[{cell.at[0], cell.at[1], cell.at[2]}];
    const rt::Vector3 n{static_cast<double>(cell.normal[0]), static_cast<double>(cell.normal[1]),
                        static_cast<double>(cell.normal[2])};
    if (rt::dot(n, back) >= 0.0) continue;
    for (float& part : cell.normal) part = -part;
  }
  return cells;
}

inline mapping::PlaneSet grown(const std::vector<SeenPoint>& cloud,
                               const mapping::PlaneGrowingConfig& config) {
  const auto owned = std::make_unique<OwnedGrowing>(config, 32768, 2048);
  for (const mapping::PlaneCell& cell : signed_cells(cloud, config.cell_m))
    (void)owned->growing.set_cell(cell);
  (void)owned->run_all();
  mapping::PlaneSet out;
  owned->growing.planes(out);
  return out;
}

/// Faces of a building that a plane may be of: counted in `found`, the plane in the building's frame.
inline bool mark_faces(const Building& in, const mapping::Plane& p, std::vector<std::uint8_t>& found,
                       std::uint8_t bit) {
  bool some = false;
  for (std::size_t b = 0; b < in.boxes.size(); ++b) {
    const SolidBox& box = in.boxes[b];
    double c[3], n[3];
    in_axes(box, p.centroid_m - box.middle_m, c);
    in_axes(box, p.normal, n);
    const double half[3] = {box.half_m.x, box.half_m.y, box.half_m.z};
    for (int f = 0; f < 6; ++f) {
      const int k = f / 2;
      const double side = f % 2 == 0 ? -1.0 : 1.0;
      if ((box.shell ? -side : side) * n[k] < 0.99 || std::fabs(c[k] - side * half[k]) > 0.15) continue;
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      if (std::fabs(c[i]) > half[i] + 0.3 || std::fabs(c[j]) > half[j] + 0.3) continue;
      found[6 * b + static_cast<std::size_t>(f)] |= bit;
      some = true;
    }
  }
  return some;
}

/// A scene of grown planes, and how much of it both sets have.
struct AirGroundScene {
  PlaneScene scene;
  std::vector<SeenPoint> air;     ///< in the source's frame
  std::vector<SeenPoint> ground;  ///< in the target's
  std::uint32_t common{};         ///< faces that both have a plane of
  bool three_directions{};        ///< in the normals of these
  double others{};                ///< share of both sets' planes that are of no such face
};

inline void count_common(const Building& in, AirGroundScene& out) {
  std::vector<std::uint8_t> found(6 * in.boxes.size());
  for (const mapping::Plane& p : out.scene.source) mark_faces(in, carried(p, out.scene.truth), found, 1);
  for (const mapping::Plane& p : out.scene.target) mark_faces(in, p, found, 2);
  double spread[3][3]{};
  std::vector<std::uint8_t> both(found.size());
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (found[f] != 3) continue;
    ++out.common;
    const rt::Vector3 n = axis_of(in.boxes[f / 6], static_cast<int>(f % 6) / 2);
    const double parts[3] = {n.x, n.y, n.z};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) spread[i][j] += parts[i] * parts[j];
    }
  }
  out.three_directions = mapping::eigen_pairs(spread).value[0] > 0.5;
  std::uint32_t of_both = 0;
  const auto common_one = [&](const mapping::Plane& p) {
    std::vector<std::uint8_t> own(found.size());
    mark_faces(in, p, own, 1);
    for (std::size_t f = 0; f < own.size(); ++f) {
      if (own[f] != 0 && found[f] == 3) return true;
    }
    return false;
  };
  for (const mapping::Plane& p : out.scene.source)
    of_both += common_one(carried(p, out.scene.truth)) ? 1u : 0u;
  for (const mapping::Plane& p : out.scene.target) of_both += common_one(p) ? 1u : 0u;
  const double all = std::max(1u, out.scene.source.size() + out.scene.target.size());
  out.others = 1.0 - of_both / all;
}

/// Planes of both clouds. The air's frame has any yaw, gravity to 0.5 degrees, and a scale of 0.9 to 1.1.
/// `above`: the building that the air sees.
inline AirGroundScene scene_of(const Building& in, const Building& above, double air_to, double ground_from,
                               WorldRandom& random) {
  AirGroundScene out;
  out.scene.truth = random_pose(random, 30, random.between(0.9, 1.1));
  const double roll = 0.0087 * random.normal();
  const rt::Quaternion tilt = rt::exp_rotation({roll, 0.0087 * random.normal(), 0});
  out.scene.truth.q_target_source = out.scene.truth.q_target_source * tilt;
  out.air = air_cloud(above, 0.05, air_to, random);
  const mapping::PlanePose back = mapping::inverse(out.scene.truth);
  for (SeenPoint& p : out.air) p = {mapping::transform(back, p.at_m), mapping::transform(back, p.from_m)};
  out.scene.source = grown(out.air, mapping::growing_config(mapping::CloudSensor::camera));
  out.ground = ground_cloud(in, ground_from, 0.95, random);
  out.scene.target = grown(out.ground, mapping::growing_config(mapping::CloudSensor::laser));
  count_common(in, out);
  return out;
}
inline AirGroundScene scene_of(const Building& in, double air_to, double ground_from, WorldRandom& random) {
  return scene_of(in, in, air_to, ground_from, random);
}

/// What became of scenes, and the errors of those that were placed: in part, those of what was observed.
struct AirGroundTally {
  PlaneTally tally;
  std::uint32_t scenes{};
  std::vector<double> position_m, angle_rad, scale;

  void add(const AirGroundScene& scene, const mapping::PlaneRegistrationResult& result) {
    ++scenes;
    tally.judge(scene.scene, result);
    if (!result.placed()) return;
    const bool whole = result.verdict == mapping::PlaneVerdict::placed;
    PoseError e = pose_error(scene.scene, result.fit.T_target_source);
    if (!whole) e.position_m = observed_error_m(scene.scene, result.fit), e.scale = 0.0;
    position_m.push_back(e.position_m), angle_rad.push_back(e.angle_rad), scale.push_back(e.scale);
  }
};

/// A share of the values lies at or below it.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Tallies by what is known (nothing; satellites and a compass) and by the share of planes of something else.
struct AirGroundRuns {
  static constexpr double kOthers[4] = {0.45, 0.55, 0.65, 1.01};
  AirGroundTally of[2][5];  ///< the last: fewer than five faces in common, or not in three directions
  AirGroundTally known;     ///< all of those with something known
};

/// Where five faces are in common in three directions, by the share of other planes; the last: elsewhere.
inline int bin_of(const AirGroundScene& scene) {
  if (scene.common < 5 || !scene.three_directions) return 4;
  int bin = 0;
  while (scene.others >= AirGroundRuns::kOthers[bin]) ++bin;
  return bin;
}

/// A row of a table.
inline void print_row(const char* name, const AirGroundTally& t, std::uint32_t seed) {
  constexpr double kDeg = 57.29577951308232;
  std::printf("| %s | %u | %u | %u | %u | %u | %.1f, %.1f, %.1f | %.3f, %.3f, %.3f | %.3f, %.3f | %u |\n",
              name, t.scenes, t.tally.close, t.tally.near, t.tally.refused, t.tally.wrong,
              1e3 * quantile(t.position_m, 0.5), 1e3 * quantile(t.position_m, 0.95),
              1e3 * quantile(t.position_m, 1.0), kDeg * quantile(t.angle_rad, 0.5),
              kDeg * quantile(t.angle_rad, 0.95), kDeg * quantile(t.angle_rad, 1.0),
              100 * quantile(t.scale, 0.95), 100 * quantile(t.scale, 1.0), seed);
}
/// Names of bins, without and with something known.
inline constexpr const char* kBinNames[2][5] = {
    {"nothing known, < 45 % other planes", "45 to 55 %", "55 to 65 %", "> 65 %", "too few faces in common"},
    {"3 m and 6 deg known, < 45 %", "45 to 55 %", "55 to 65 %", "> 65 %", "too few faces in common"}};

/// The air sees the first 80 % of a building, the ground the last 80 %.
inline AirGroundRuns air_ground_trials(std::uint32_t seed, std::uint32_t trials) {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  AirGroundRuns out;
  for (std::uint32_t i = 0; i < trials; ++i) {
    WorldRandom random(seed + i);
    const Building building = random_building(random);
    const AirGroundScene scene = scene_of(building, 0.8, 0.2, random);
    const int bin = bin_of(scene);
    for (int known = 0; known < 2; ++known) {
      const mapping::PlaneEstimate estimate = gps(scene.scene, known == 1, 0.05, random);
      const mapping::PlaneRegistrationResult result = registered(*registration, scene.scene, estimate);
      out.of[known][bin].add(scene, result);
      if (known == 1 && bin < 4) out.known.add(scene, result);
    }
  }
  return out;
}

/// A corridor without ends (0), a floor with nothing on it (1), two walls and no floor in sight (2): the
/// air's position and yaw are known as satellites and a compass know them.
inline AirGroundTally deficient_trials(std::uint32_t seed, std::uint32_t trials) {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  AirGroundTally out;
  for (std::uint32_t i = 0; i < trials; ++i) {
    WorldRandom random(seed + i);
    const std::uint32_t kind = i % 3;
    Building building;
    const double wide = kind == 1 ? 200 : random.between(4, 8);
    building.size_m = {30, wide, random.between(4, 6)};
    const double low = kind == 2 ? 30 : 0;
    const rt::Vector3 half{200, 0.5 * wide, 0.5 * (building.size_m.z + 2 * low)};
    building.add(random, {15, 0.5 * wide, 0.5 * building.size_m.z}, half, {}, true);
    for (bool& textured : building.boxes[0].textured) textured = true;
    if (kind == 0) {
      for (int k = 0; k < 3; ++k)  // ledges along the walls, without ends
        building.add(random, {15, 0.0, random.between(0.3, 2.0)}, {200, 0.5, 0.2}, {});
    }
    const AirGroundScene scene = scene_of(building, 0.8, 0.2, random);
    out.add(scene, registered(*registration, scene.scene, gps(scene.scene, true, 0.05, random)));
  }
  return out;
}

}  // namespace sortie::tests
