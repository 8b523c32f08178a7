// SPDX-License-Identifier: BSD-3-Clause
// The search for a place against brute force: every yaw that two walls give, with every three pairs of
// planes.
#include <catch2/catch.hpp>
#include <memory>

#include "tests/mapping/plane_trials.hpp"

namespace {
using namespace sortie;
using rt::dot;
using rt::Vector3;

/// Corners of a plane's rectangle, in the frame of its set.
std::vector<Vector3> corners_of(const mapping::Plane& p) {
  std::vector<Vector3> all;
  for (const double u : {p.least_m[0], p.most_m[0]}) {
    for (const double v : {p.least_m[1], p.most_m[1]})
      all.push_back(p.centroid_m + u * p.axis_u + v * p.axis_v());
  }
  return all;
}

/// Boxes around the corners along the target's own two axes meet: eq. 1 of the published method.
bool boxes_meet(const mapping::Plane& t, const std::vector<Vector3>& placed) {
  for (const Vector3& axis : {t.axis_u, t.axis_v()}) {
    double low[2] = {1e9, 1e9};
    double high[2] = {-1e9, -1e9};
    int k = 0;
    for (const std::vector<Vector3>& points : {corners_of(t), placed}) {
      for (const Vector3& x : points) {
        low[k] = std::min(low[k], dot(axis, x));
        high[k] = std::max(high[k], dot(axis, x));
      }
      ++k;
    }
    if (low[0] > high[1] || low[1] > high[0]) return false;
  }
  return true;
}

/// Planes of the source that a pose lays onto one of the target's, within 8 cm and 2 degrees.
std::uint32_t agreement(const tests::PlaneScene& scene, const mapping::PlanePose& pose) {
  std::uint32_t count = 0;
  for (const mapping::Plane& s : scene.source) {
    const mapping::Plane placed = tests::carried(s, pose);
    bool met = false;
    for (const mapping::Plane& t : scene.target) {
      if (met || dot(placed.normal, t.normal) < 0.99939) continue;
      if (std::fabs(dot(t.normal, placed.centroid_m) - t.offset_m) > 0.08) continue;
      met = boxes_meet(t, corners_of(placed));
    }
    count += met ? 1u : 0u;
  }
  return count;
}

/// The best agreement of all hypotheses.
std::uint32_t brute_force(const tests::PlaneScene& scene) {
  std::uint32_t best = 0;
  std::vector<double> yaws;
  const auto wall = [](const mapping::Plane& p) { return std::fabs(p.normal.z) < 0.5; };
  for (const mapping::Plane& s : scene.source) {
    for (const mapping::Plane& t : scene.target) {
      if (!wall(s) || !wall(t)) continue;
      const double yaw = std::atan2(t.normal.y, t.normal.x) - std::atan2(s.normal.y, s.normal.x);
      bool known = false;  // within a tenth of a degree
      for (const double other : yaws) known = known || std::cos(yaw - other) > 0.9999985;
      if (!known) yaws.push_back(yaw);
    }
  }
  for (const double yaw : yaws) {
    mapping::PlanePose pose;
    pose.q_target_source = rt::from_yaw_pitch_roll(yaw, 0, 0);
    struct Pair {
      Vector3 normal;
      double shift;
    };
    std::vector<Pair> pairs;
    for (const mapping::Plane& s : scene.source) {
      const mapping::Plane turned = tests::carried(s, pose);
      for (const mapping::Plane& t : scene.target) {
        if (dot(turned.normal, t.normal) > 0.99)
          pairs.push_back({t.normal, dot(t.normal, t.centroid_m - turned.centroid_m)});
      }
    }
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      for (std::size_t j = i + 1; j < pairs.size(); ++j) {
        const Vector3 square = rt::cross(pairs[i].normal, pairs[j].normal);
        if (rt::norm(square) < 0.3) continue;
        for (std::size_t k = j + 1; k < pairs.size(); ++k) {
          const double det = dot(square, pairs[k].normal);
          if (std::fabs(det) < 0.3) continue;
          pose.p_target_source_m =
              (1.0 / det) *
              (pairs[i].shift * rt::cross(pairs[j].normal, pairs[k].normal) +
               pairs[j].shift * rt::cross(pairs[k].normal, pairs[i].normal) + pairs[k].shift * square);
          best = std::max(best, agreement(scene, pose));
        }
      }
    }
  }
  return best;
}
}  // namespace

TEST_CASE("A place that is found agrees with as many planes as the best of all hypotheses") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  constexpr std::uint32_t kSeed = 12000;
  CAPTURE(kSeed);
  std::uint32_t placed = 0;
  std::uint32_t less = 0;
  for (std::uint32_t i = 0; i < 40; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::PlaneNoise fine{0.005, 0.002, 0.7};
    const tests::PlaneScene scene = tests::random_scene(7, 3, 3, 1.0, fine, fine, random);
    const mapping::PlaneRegistrationResult result = tests::registered(*registration, scene, {});
    if (!result.placed()) continue;
    ++placed;
    const std::uint32_t ours = agreement(scene, result.fit.T_target_source);
    const std::uint32_t best = brute_force(scene);
    CAPTURE(i, ours, best);
    CHECK(ours + 1 >= best);
    if (ours < best) ++less;
  }
  CAPTURE(placed, less);
  CHECK(placed >= 30);
  CHECK(less <= 2);
}

TEST_CASE("Exact planes without others: all of them agree, to a millimetre") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  std::uint32_t placed = 0;
  for (std::uint32_t i = 0; i < 100; ++i) {
    tests::WorldRandom random(13000 + i);
    const tests::PlaneScene scene = tests::random_scene(12, 0, 0, 1.0, {0, 0, 1}, {0, 0, 1}, random);
    const mapping::PlaneRegistrationResult result = tests::registered(*registration, scene, {});
    if (!result.placed()) continue;
    ++placed;
    CHECK(result.matched == 12);
    const tests::PoseError e = tests::pose_error(scene, result.fit.T_target_source);
    CHECK(e.position_m < 1e-3);
    CHECK(e.angle_rad < 1e-4);
  }
  CHECK(placed >= 90);
}
