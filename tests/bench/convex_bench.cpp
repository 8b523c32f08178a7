// SPDX-License-Identifier: BSD-3-Clause
// Judging pairs of convex bodies, beside what raw calls of libccd cost on the same pairs. libccd's answer is
// one direction and point, ours the smallest depth and a manifold: the ratio is the price of that.
#include <benchmark/benchmark.h>
#include <ccd/ccd.h>

#include <random>
#include <vector>

#include "rt/convex/manifold.hpp"
#include "rt/convex/support.hpp"

namespace {

using namespace sortie::rt;
using namespace sortie::rt::convex;

constexpr std::size_t kPairs = 512;
enum class Scene : std::uint8_t { boxes, apart, floor, nose, corners };

struct Pair {
  Convex a;
  Convex b;
};

std::vector<Pair> pairs(Scene scene) {
  std::mt19937 random(5);
  const auto draw = [&random](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  const auto turn = [&draw] {
    const double x = draw(-1.5, 1.5);
    const double y = draw(-1.5, 1.5);
    const double z = draw(-1.5, 1.5);
    return exp_rotation({x, y, z});
  };
  std::vector<Pair> all;
  while (all.size() < kPairs) {
    Pair p{make_track(0.09047, 0.09047, 0.5, 0.04865), make_box({0.5, 0.5, 0.1})};
    const double x = draw(-0.3, 0.3);
    const double y = draw(-0.3, 0.3);
    const double yaw = draw(-0.03, 0.03);
    const double depth = draw(0.0001, 0.001);
    switch (scene) {
      case Scene::boxes:
        p.a = make_box({0.2, 0.3, 0.1});
        place(p.a, {x, y, draw(0.0, 0.5)}, turn());
        break;
      case Scene::apart:
        place(p.a, {x, y, draw(0.45, 0.9)}, turn());
        break;
      case Scene::floor:
        place(p.a, {x - 0.25, 0.3 * y, 0.1 + 0.09047 - depth}, from_yaw_pitch_roll(yaw, 0, 0));
        break;
      case Scene::nose: {
        const SinCos s = sincos(draw(0.4, 1.2));
        const double r = 0.09047 - depth;
        place(p.a, {-0.5 - r * s.cos, 0.3 * y, 0.1 + r * s.sin}, from_yaw_pitch_roll(yaw, -1.57, 0));
        break;
      }
      case Scene::corners: {
        place(p.a, {}, turn());
        const Vector3 d{0.5, 0.6, 0.62449979983983983};
        p.a.p_world_m = support(p.b, d) - support(p.a, -1.0 * d) - depth * d;
        break;
      }
    }
    all.push_back(p);
  }
  return all;
}

template <class Each>
void run(benchmark::State& state, Scene scene, Each each) {
  const std::vector<Pair> all = pairs(scene);
  for (auto _ : state) {
    for (const Pair& p : all) each(p);
  }
  state.counters["ops"] = static_cast<double>(kPairs);
}

void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const Vector3 p =
      support(*static_cast<const Convex*>(object), {direction->v[0], direction->v[1], direction->v[2]});
  ccdVec3Set(out, p.x, p.y, p.z);
}

void ccd_centre(const void* object, ccd_vec3_t* out) {
  const Vector3 p = middle(*static_cast<const Convex*>(object));
  ccdVec3Set(out, p.x, p.y, p.z);
}

ccd_t settings() {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd_support;
  ccd.support2 = ccd_support;
  ccd.center1 = ccd_centre;
  ccd.center2 = ccd_centre;
  ccd.max_iterations = 100;
  return ccd;
}

void with_query(benchmark::State& state, Scene scene) {
  run(state, scene, [](const Pair& p) { benchmark::DoNotOptimize(query(p.a, p.b)); });
}
void with_manifold(benchmark::State& state, Scene scene) {
  run(state, scene, [](const Pair& p) { benchmark::DoNotOptimize(manifold(p.a, p.b)); });
}
void with_portal(benchmark::State& state, Scene scene) {
  const ccd_t ccd = settings();
  run(state, scene, [&ccd](const Pair& p) {
    double depth = 0.0;
    ccd_vec3_t direction;
    ccd_vec3_t position;
    benchmark::DoNotOptimize(ccdMPRPenetration(&p.b, &p.a, &ccd, &depth, &direction, &position));
  });
}
void with_intersect(benchmark::State& state, Scene scene) {
  const ccd_t ccd = settings();
  run(state, scene, [&ccd](const Pair& p) { benchmark::DoNotOptimize(ccdMPRIntersect(&p.b, &p.a, &ccd)); });
}

#define SORTIE_CONVEX_BENCH(group, scene, ours)                                         \
  BENCHMARK_CAPTURE(ours, scene, Scene::scene)->Name(group "/sortie");                  \
  BENCHMARK_CAPTURE(with_portal, scene, Scene::scene)->Name(group "/libccd MPR depth"); \
  BENCHMARK_CAPTURE(with_intersect, scene, Scene::scene)->Name(group "/libccd MPR yes or no")

SORTIE_CONVEX_BENCH("query_box_box", boxes, with_query);
SORTIE_CONVEX_BENCH("query_track_box_apart", apart, with_query);
SORTIE_CONVEX_BENCH("manifold_track_on_box", floor, with_manifold);
SORTIE_CONVEX_BENCH("manifold_wheel_on_nose", nose, with_manifold);
SORTIE_CONVEX_BENCH("manifold_corners", corners, with_manifold);

void ground(benchmark::State& state) {
  run(state, Scene::floor, [](const Pair& p) {
    benchmark::DoNotOptimize(manifold(p.a, HalfSpace{{0, 0, 1}, 0.1}));
  });
}
BENCHMARK(ground)->Name("manifold_track_on_plane/sortie");

}  // namespace
