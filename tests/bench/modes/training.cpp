// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/modes/training.hpp"

#include <cmath>
#include <cstdio>

#include "tests/bench/modes/course_run.hpp"

namespace sortie::bench {
namespace {

using estimators::ObstacleModes;
using estimators::ObstacleModesConfig;
using rt::Quaternion;

constexpr double kCreep_m_s = 0.03;   // as in ObstacleModesConfig: way that time alone makes
constexpr double kWalk_rad = 5e-5;    // noise of the second pass: attitude, per step
constexpr double kBias_rad = 0.0035;  // its bias
constexpr double kSlip = 1.02;
constexpr double kLength = 0.03, kRadius = 0.1, kCom_m = 0.02;  // how far its geometry may be off
constexpr int kPivotTrees = 6;
constexpr int kPivotDepth = 8;
constexpr int kSideDepth = 4;
constexpr int kNameDepth = 8;

Quaternion plain(const hil::Quat& q) { return {q.w, q.x, q.y, q.z}; }

/// Of slow drives one step of so many stands for the others.
std::size_t thinned_at(double speed_m_s) { return speed_m_s < 0.1 ? 6 : speed_m_s < 0.3 ? 2 : 1; }

}  // namespace

/// What the modes looked at in each step, what the body really did along its normal, and its true mode.
void Trainer::collect(const std::vector<CourseSample>& drive, double direction, bool disturbed,
                      std::size_t thinned) {
  ObstacleModesConfig config;
  double bias = 0.0;
  if (disturbed) {
    bias = random_.chance(0.5) ? kBias_rad : -kBias_rad;
    config.profile.half_length_m *= 1.0 + random_.uniform(-kLength, kLength);
    config.profile.radius_m *= 1.0 + random_.uniform(-kRadius, kRadius);
    config.profile.com_x_m += random_.uniform(-kCom_m, kCom_m);
  }
  ObstacleModes modes(config);
  const double walk = disturbed ? kWalk_rad : 0.0;
  double pitch = 0.0, roll = 0.0;
  Quaternion before;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    pitch = 0.998 * pitch + walk * random_.normal();
    roll = 0.998 * roll + walk * random_.normal();
    const Quaternion now = plain(drive[i].q_world_body) * rt::from_yaw_pitch_roll(0, bias + pitch, roll);
    if (i > 0) {
      const CourseSample& a = drive[i - 1];
      const CourseSample& b = drive[i];
      estimators::ObstacleStep step;
      step.dt_s = b.t_s - a.t_s;
      step.travel_m = 0.5 * (b.left_m - a.left_m + b.right_m - a.right_m) * (disturbed ? kSlip : 1.0);
      step.turn_rad = log_rotation(conjugate(before) * now);
      step.up_begin = rotate_back(before, {0, 0, 1});
      step.up_end = rotate_back(now, {0, 0, 1});
      step.flippers = {0.5 * (b.flipper_rad[0] + b.flipper_rad[1]),
                       0.5 * (b.flipper_rad[2] + b.flipper_rad[3])};
      static_cast<void>(modes.update(step));
      const hil::Vec3 moved = b.p_world_m - a.p_world_m;
      const Quaternion half = rt::slerp(plain(a.q_world_body), plain(b.q_world_body), 0.5);
      const double way = std::fabs(step.travel_m) + kCreep_m_s * step.dt_s;
      int mode = true_mode(a, b, direction);
      if (direction < 0.0 && (mode == 1 || mode == 3)) mode = 4 - mode;
      if (i % thinned == 0)
        set_.add(modes, step, way, rotate_back(half, {moved.x, moved.y, moved.z}).z, mode,
                 static_cast<double>(thinned));
    }
    before = now;
  }
}

void Trainer::add(const CourseScene& scene, const std::vector<CourseSample>& drive, double speed_m_s) {
  if (!run_course(scene, drive, {}, 1).crossed) return;
  const double direction = scene.way_m < 0 ? -1.0 : 1.0;
  collect(drive, direction, false, thinned_at(speed_m_s));
  collect(drive, direction, true, thinned_at(speed_m_s));
  ++set_.drive;
}

void Trainer::finish() {
  std::vector<GrownTree> pivot;
  GrownTree side;
  for (int round = 0; round < 2; ++round) {  // each learns what the other leaves over
    pivot = grow_pivot_trees(set_, round == 0 ? 1 : kPivotTrees, kPivotDepth);
    side = grow_side_tree(set_, kSideDepth);
  }
  print_trees(set_, pivot, side, grow_name_tree(set_, kNameDepth));
}

void train_modes(const std::vector<std::uint64_t>& seeds) {
  Trainer trainer(seeds.front());
  for (const std::uint64_t seed : seeds) {
    for (const CourseScene& scene : course_scenes(seed)) {
      for (const hil::ContactMode mode : {hil::ContactMode::csm, hil::ContactMode::belt}) {
        for (const double speed : {0.05, 0.15, 0.5})
          trainer.add(scene, drive_course(scene, speed, mode), speed);
      }
    }
    std::fprintf(stderr, "seed %llu: %zu steps\n", static_cast<unsigned long long>(seed), trainer.steps());
  }
  trainer.finish();
}

}  // namespace sortie::bench
