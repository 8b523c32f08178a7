// SPDX-License-Identifier: BSD-3-Clause
// The score of a pose, by its returns and by their rays.
#include "mapping/registration/match_score.hpp"

#include <catch2/catch.hpp>

#include "tests/mapping/registration_rig.hpp"

namespace {
using namespace sortie;

struct ScoreScene {
  testing::OwnedSurfelLayer owned{0.4, 7, 5, 16384};
  testing::RegistrationWorld world;
  testing::TestLidar lidar;
  mapping::RigidPose pose;
  std::vector<mapping::SamplePoint> sample;

  explicit ScoreScene(testing::Draws& draws) : world(testing::small_room(draws)) {
    lidar.columns = 240;
    for (std::uint32_t scan = 1; scan <= 4; ++scan) {
      const mapping::RigidPose at{{0.2 * scan - 0.5, 0.1 * scan, 1.2}, rt::exp_rotation({0, 0, 0.2 * scan})};
      owned.insert(testing::placed(lidar.scan(world, at.p, at.q, draws), at), scan, at.p);
    }
    pose = {{0.2, 0.2, 1.2}, rt::exp_rotation({0, 0, draws.uniform(-0.5, 0.5)})};
    lidar.columns = 100;
    sample = testing::as_sample(lidar.scan(world, pose.p, pose.q, draws));
  }
};

/// The score as it is described, with the cell's whole covariance.
mapping::MatchScore score_twin(const mapping::SurfelLayer& layer,
                               const std::vector<mapping::SamplePoint>& sample,
                               const mapping::RigidPose& pose, double sigma_m) {
  mapping::MatchScore score;
  for (const mapping::SamplePoint& point : sample) {
    const rt::Vector3 p = rt::rotate(pose.q, {static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                                              static_cast<double>(point.z_m)}) +
                          pose.p;
    const mapping::SurfelCell cell{{static_cast<std::int32_t>(std::floor(p.x / layer.cell_m())),
                                    static_cast<std::int32_t>(std::floor(p.y / layer.cell_m())),
                                    static_cast<std::int32_t>(std::floor(p.z / layer.cell_m()))}};
    mapping::SurfelIndex index = layer.find(cell);
    if (index != mapping::kNoSurfel && testing::is_from_behind(layer, cell, p - pose.p))
      index = layer.other_side(index);
    if (index == mapping::kNoSurfel || layer.surfel(index).count == 0) continue;
    const mapping::Surfel* const surfel = &layer.surfel(index);
    const rt::Vector3 off =
        p - layer.centre_m(cell) -
        rt::Vector3{static_cast<double>(surfel->mean_m[0]), static_cast<double>(surfel->mean_m[1]),
                    static_cast<double>(surfel->mean_m[2])};
    double d2 = 0;
    for (int i = 0; i < 3; ++i) {
      const rt::Vector3 a{static_cast<double>(surfel->axis[i][0]), static_cast<double>(surfel->axis[i][1]),
                          static_cast<double>(surfel->axis[i][2])};
      const double deviation = std::hypot(std::sqrt(static_cast<double>(surfel->variance_m2[i])), sigma_m);
      d2 += std::pow(rt::dot(a, off) / deviation, 2);
    }
    score.known += 1;
    score.matched += std::sqrt(d2) < 3 ? 1 : 0;
    score.value += 1 / (1 + d2 * d2 / 9);
  }
  const auto all = static_cast<double>(sample.size());
  return {score.value / all, score.matched / all, score.known / all};
}
}  // namespace

TEST_CASE("A scan's score is that of a twin, and best where the scan was taken") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 6; ++run) {
    const ScoreScene scene(draws);
    const auto score = [&](const mapping::RigidPose& pose) {
      return mapping::match_score(scene.owned.layer, scene.sample, pose, 0.02);
    };
    const mapping::MatchScore right = score(scene.pose);
    CHECK(right.known > 0.9);
    CHECK(right.matched > 0.9 * right.known);
    CHECK(right.value <= 1.0);
    for (int i = 0; i < 12; ++i) {
      const double by = i < 6 ? 0.25 : 0.06;
      mapping::RigidPose wrong = scene.pose;
      if (i % 2 == 0) wrong.p = wrong.p + by * draws.direction();
      if (i % 2 == 1) wrong.q = rt::exp_rotation(by * draws.direction()) * wrong.q;
      const mapping::MatchScore found = score(wrong);
      CHECK(found.value < right.value);
      CHECK(found.matched <= found.known);
      CHECK(found.value <= found.known);
      const mapping::MatchScore twin = score_twin(scene.owned.layer, scene.sample, wrong, 0.02);
      CHECK(found.known == Approx(twin.known).margin(1e-12));
      // Places in a cell are whole steps of 0.1 mm; deviations are 2 cm and more.
      CHECK(found.matched == Approx(twin.matched).margin(0.005));
      CHECK(found.value == Approx(twin.value).margin(0.005));
    }
    mapping::RigidPose far = scene.pose;
    for (const double at : {1e3, 1e7, std::numeric_limits<double>::quiet_NaN()}) {
      far.p.x = at;
      CHECK(score(far).known == 0.0);
      CHECK(score(far).value == 0.0);
    }
    CHECK(mapping::match_score(scene.owned.layer, {}, scene.pose, 0.02).value == 0.0);
  }
}

TEST_CASE("Rays go through a wall between sensor and returns, and through none where the scan was taken") {
  testing::Draws draws(11);
  std::uint32_t all = 0;
  for (int run = 0; run < 6; ++run) {
    ScoreScene scene(draws);
    const auto through = [&](const std::vector<mapping::SamplePoint>& sample, std::uint32_t rays,
                             std::uint32_t most_cells = 64) {
      return mapping::rays_through_surfaces(scene.owned.layer, sample, scene.pose, rays, most_cells);
    };
    CHECK(through(scene.sample, 128) <= 6);
    // The same returns twice as far out: what the map has there stands in the way of many, and of not all
    // where a ray meets a surface at its rim.
    std::vector<mapping::SamplePoint> behind = scene.sample;
    for (mapping::SamplePoint& p : behind) p.x_m *= 2, p.y_m *= 2, p.z_m *= 2;
    CHECK(through(behind, 128) > 8);
    all += through(behind, 128);
    CHECK(through(behind, 128) <= 128);
    CHECK(through(behind, 128, 4) <= through(behind, 128) / 2);
    CHECK(through({}, 128) == 0);
  }
  CHECK(all > 6 * 30);
}

TEST_CASE("Of the rays no more are looked at than were asked for, evenly from the whole sample") {
  // One wall, and returns behind it straight through the middles of its cells.
  testing::OwnedSurfelLayer owned(0.4, 6, 5, 8192);
  testing::Draws draws(1);
  std::vector<rt::Vector3> wall;
  for (int i = 0; i < 40'000; ++i) wall.push_back({3.0, draws.uniform(-3, 3), draws.uniform(-3, 3)});
  owned.insert(wall, 1);
  for (const std::size_t returns : {1, 100, 127, 128, 129, 200, 255, 256, 257, 1000, 3072}) {
    const auto looked_at = static_cast<std::uint32_t>(std::min<std::size_t>(128, returns));
    INFO(returns << " returns");
    // All of them, every fourth, or the last quarter.
    for (int kind = 0; kind < 3; ++kind) {
      std::vector<mapping::SamplePoint> sample;
      for (std::size_t i = 0; i < returns; ++i) {
        const bool behind = kind == 0 || (kind == 1 ? i % 4 == 0 : 4 * i >= 3 * returns);
        const float away = behind ? 2.7f : 0.5f;
        sample.push_back({3.0f * away, 0.4f * (static_cast<float>(i % 7) - 2.5f) * away,
                          0.4f * (static_cast<float>(i / 7 % 6) - 2.5f) * away});
      }
      const std::uint32_t through = mapping::rays_through_surfaces(owned.layer, sample, {}, 128, 64);
      if (kind == 0) CHECK(through == looked_at);
      if (kind == 2) CHECK(std::fabs(through - 0.25 * looked_at) <= 1.0);
      CHECK(through <= looked_at);
    }
    // Returns before the wall, and just behind it, have nothing in their way.
    for (const float away : {0.3f, 0.9f, 1.04f}) {
      const std::vector<mapping::SamplePoint> sample(returns, {3.0f * away, 0.2f * away, 0.2f * away});
      CHECK(mapping::rays_through_surfaces(owned.layer, sample, {}, 128, 64) == 0);
    }
  }
}
