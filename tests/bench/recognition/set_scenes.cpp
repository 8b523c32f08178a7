// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/set_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace sortie::bench {
namespace {
using mapping::PlaceCm;

constexpr std::uint32_t kTargets = 1204;
constexpr std::uint32_t kSegments = 53;
constexpr std::uint32_t kEach = 58;

class SceneDraws {
 public:
  explicit SceneDraws(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(engine_() >> 11), -53);
  }
  std::int32_t whole(double low, double high) { return static_cast<std::int32_t>(uniform(low, high)); }
  template <class List>
  void shuffle(List& list) {
    for (std::size_t i = list.size(); i > 1; --i) {
      std::swap(list[i - 1], list[static_cast<std::size_t>(uniform(0, static_cast<double>(i)))]);
    }
  }

 private:
  std::mt19937_64 engine_;
};

/// Houses, trees and cars on both sides of streets that turn every 80 m or not.
std::vector<PlaceCm> street(SceneDraws& draws) {
  std::vector<PlaceCm> targets;
  double x = 0.0, y = 0.0;
  int heading = 0;
  for (std::uint32_t i = 0; i < kTargets; ++i) {
    const double along[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const double* way = along[heading % 4];
    x += 300.0 * way[0];
    y += 300.0 * way[1];
    if (i % 27 == 26) heading += draws.whole(0, 3) + 3;
    const double side = (draws.uniform(0, 1) < 0.5 ? -1 : 1) * draws.uniform(400, 2000);
    targets.push_back({static_cast<std::int32_t>(x - side * way[1]),
                       static_cast<std::int32_t>(y + side * way[0]), draws.whole(0, 400)});
  }
  return targets;
}

struct Turned {
  double cosine, sine;
  PlaceCm operator()(double x, double y, std::int32_t z) const {
    return {static_cast<std::int32_t>(std::floor(cosine * x - sine * y)),
            static_cast<std::int32_t>(std::floor(sine * x + cosine * y)), z};
  }
};
}  // namespace

SetScene street_scene(std::uint64_t seed) {
  SceneDraws draws(seed);
  const std::vector<PlaceCm> targets = street(draws);
  const PlaceCm& here = targets[static_cast<std::size_t>(draws.whole(100, 1100))];
  std::vector<std::uint16_t> near;
  for (std::uint32_t t = 0; t < kTargets; ++t) {
    if (std::hypot(targets[t].x - here.x, targets[t].y - here.y) < 5000)
      near.push_back(static_cast<std::uint16_t>(t));
  }
  draws.shuffle(near);
  const std::uint32_t known = std::min<std::uint32_t>(kSegments / 2, static_cast<std::uint32_t>(near.size()));
  const double yaw = draws.uniform(-3, 3);
  const Turned turned{std::cos(yaw), std::sin(yaw)};
  SetScene scene;
  scene.segments = kSegments;
  scene.targets = kTargets;
  for (std::uint16_t s = 0; s < kSegments; ++s) {
    PlaceCm place = turned(draws.uniform(-4000, 4000), draws.uniform(-4000, 4000), draws.whole(0, 400));
    std::vector<std::uint16_t> candidates;
    if (s < known) {
      const PlaceCm& t = targets[near[s]];
      place = turned(t.x - here.x + draws.uniform(-15, 15), t.y - here.y + draws.uniform(-15, 15),
                     t.z + draws.whole(-15, 16));
      candidates.push_back(near[s]);
    }
    while (candidates.size() < kEach) {
      const auto t = static_cast<std::uint16_t>(draws.whole(0, kTargets));
      if (std::find(candidates.begin(), candidates.end(), t) == candidates.end()) candidates.push_back(t);
    }
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      scene.pairs.push_back({{s, candidates[k]}, place, targets[candidates[k]]});
      scene.right.push_back(s < known && k == 0);
    }
  }
  return scene;
}

SetScene outlier_scene(int count, double wrong, std::uint64_t seed) {
  SceneDraws draws(seed);
  const double yaw = draws.uniform(-3, 3);
  const Turned turned{std::cos(yaw), std::sin(yaw)};
  SetScene scene;
  scene.segments = scene.targets = static_cast<std::uint32_t>(count);
  const int right = count - static_cast<int>(wrong * count + 0.5);
  for (int i = 0; i < count; ++i) {
    const PlaceCm segment{draws.whole(-2500, 2500), draws.whole(-2500, 2500), draws.whole(0, 400)};
    PlaceCm target{draws.whole(-2500, 2500), draws.whole(-2500, 2500), draws.whole(0, 400)};
    if (i < right) {
      target = turned(segment.x, segment.y, segment.z + draws.whole(-10, 11));
      target.x += draws.whole(-10, 11);
      target.y += draws.whole(-10, 11);
    }
    const auto n = static_cast<std::uint16_t>(i);
    scene.pairs.push_back({{n, n}, segment, target});
    scene.right.push_back(i < right);
  }
  return scene;
}

}  // namespace sortie::bench
