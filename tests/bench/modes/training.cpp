// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/modes/training.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "hil/random.hpp"
#include "tests/bench/modes/course_run.hpp"
#include "tests/bench/modes/tree_growth.hpp"

namespace sortie::bench {
namespace {

using estimators::ObstacleModes;
using estimators::ObstacleModesConfig;
using rt::Quaternion;

constexpr double kCreep_m_s = 0.03;   // as in ObstacleModesConfig: way that time alone makes
constexpr double kWalk_rad = 5e-5;    // noise of the second pass: attitude, per step
constexpr double kBias_rad = 0.0035;  // its bias
constexpr double kSlip = 1.02;
constexpr std::size_t kThinned = 3;  // of slow drives, one step of so many
constexpr int kPivotDepth = 7;
constexpr int kSideDepth = 4;

Quaternion plain(const hil::Quat& q) { return {q.w, q.x, q.y, q.z}; }

/// Adds the steps of one drive: what the modes looked at, and what the body really did along its normal.
void collect(const std::vector<CourseSample>& drive, bool noisy, std::size_t thinned, hil::Random& random,
             TrainingSet& set) {
  ObstacleModes modes{ObstacleModesConfig{}};
  const double bias = noisy ? (random.chance(0.5) ? kBias_rad : -kBias_rad) : 0.0;
  const double walk = noisy ? kWalk_rad : 0.0;
  double pitch = 0.0, roll = 0.0;
  Quaternion before;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    pitch = 0.998 * pitch + walk * random.normal();
    roll = 0.998 * roll + walk * random.normal();
    const Quaternion now = plain(drive[i].q_world_body) * rt::from_yaw_pitch_roll(0, bias + pitch, roll);
    if (i > 0) {
      const CourseSample& a = drive[i - 1];
      const CourseSample& b = drive[i];
      estimators::ObstacleStep step;
      step.dt_s = b.t_s - a.t_s;
      step.travel_m = 0.5 * (b.left_m - a.left_m + b.right_m - a.right_m) * (noisy ? kSlip : 1.0);
      step.turn_rad = log_rotation(conjugate(before) * now);
      step.up_begin = rotate_back(before, {0, 0, 1});
      step.up_end = rotate_back(now, {0, 0, 1});
      step.flippers = {0.5 * (b.flipper_rad[0] + b.flipper_rad[1]),
                       0.5 * (b.flipper_rad[2] + b.flipper_rad[3])};
      static_cast<void>(modes.update(step));
      const hil::Vec3 moved = b.p_world_m - a.p_world_m;
      const Quaternion half = rt::slerp(plain(a.q_world_body), plain(b.q_world_body), 0.5);
      const double way = std::fabs(step.travel_m) + kCreep_m_s * step.dt_s;
      if (i % thinned == 0)
        set.add(modes, step, way, rotate_back(half, {moved.x, moved.y, moved.z}).z,
                static_cast<double>(thinned));
    }
    before = now;
  }
}

}  // namespace

void train_modes(const std::vector<std::uint64_t>& seeds) {
  TrainingSet set;
  hil::Random random(seeds.front(), 0x747265);
  for (const std::uint64_t seed : seeds) {
    for (const CourseScene& scene : course_scenes(seed)) {
      for (const hil::ContactMode mode : {hil::ContactMode::csm, hil::ContactMode::belt}) {
        for (const double speed : {0.05, 0.15, 0.5}) {
          const std::vector<CourseSample> drive = drive_course(scene, speed, mode);
          if (!run_course(scene, drive, {}, seed).crossed) continue;
          const std::size_t thinned = speed < 0.1 ? kThinned : 1;
          collect(drive, false, thinned, random, set);
          collect(drive, true, thinned, random, set);
        }
      }
    }
    std::fprintf(stderr, "seed %llu: %zu steps\n", static_cast<unsigned long long>(seed), set.steps.size());
  }
  std::vector<GrownNode> pivot, side;
  for (int round = 0; round < 2; ++round) {  // each tree learns what the other leaves over
    pivot = grow_pivot_tree(set, kPivotDepth);
    side = grow_side_tree(set, kSideDepth);
  }
  print_trees(set, pivot, side);
}

}  // namespace sortie::bench
