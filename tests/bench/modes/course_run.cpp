// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/modes/course_run.hpp"

#include <algorithm>
#include <cmath>

#include "hil/random.hpp"

namespace sortie::bench {
namespace {

using estimators::ObstacleMode;
using estimators::TrackOdometry;
using estimators::TrackOdometryConfig;
using rt::Quaternion;
using rt::Vector3;

constexpr double kCollar_m = 0.03;
constexpr double kTurning_rad_m = 0.3;    // slower truth is planar
constexpr double kEnd_m = 0.2;            // contacts beyond are at an end of the robot
constexpr double kOneEdge_m = 0.05;       // contacts nearer together are one
constexpr double kAttitudeKeeps = 0.998;  // a step of 10 ms of 5 s

Quaternion plain(const hil::Quat& q) { return {q.w, q.x, q.y, q.z}; }
double travel(const CourseSample& a, const CourseSample& b) {
  return 0.5 * (b.left_m - a.left_m + b.right_m - a.right_m);
}

/// The samples of a drive with their disturbance, fed to an odometry.
class Feed {
 public:
  Feed(const Disturbance& wrong, std::uint64_t seed) : wrong_(wrong), random_(seed, 0x6f646f) {
    bias_rad_ = random_.chance(0.5) ? wrong.attitude_bias_rad : -wrong.attitude_bias_rad;
    for (double& bias : force_bias_) bias = wrong.force_bias_m_s2 * random_.normal();
  }

  /// Makes the next sample of a drive what sensors say. Every odometry gets the same.
  void next(const CourseSample& truth) {
    walk_[0] = kAttitudeKeeps * walk_[0] + wrong_.attitude_walk_rad * random_.normal();
    walk_[1] = kAttitudeKeeps * walk_[1] + wrong_.attitude_walk_rad * random_.normal();
    const rt::Nanoseconds before_ns = imu_.stamp_ns;
    imu_.stamp_ns = rt::Nanoseconds{1000000000} +
                    static_cast<rt::Nanoseconds>(std::lround(1e3 * (truth.t_s + 1))) * 1000000;
    const Quaternion q =
        plain(truth.q_world_body) * rt::from_yaw_pitch_roll(0, bias_rad_ + walk_[1], walk_[0]);
    attitude_.stamp_ns = imu_.stamp_ns;
    if (before_ns > 0) {
      const double dt = rt::to_seconds(imu_.stamp_ns - before_ns);
      rt::store((1.0 / dt) * log_rotation(conjugate(rt::to_quaternion(attitude_.q_world_body)) * q),
                attitude_.w_body_rad_s);
    }
    rt::store(q, attitude_.q_world_body);
    imu_.flags = rt::kImuAcc | rt::kImuMeanRate;
    const double force[3] = {truth.force_m_s2.x, truth.force_m_s2.y, truth.force_m_s2.z};
    // An attitude that leans by b at rest does so because the accelerometer's x axis is off by g b.
    const double hidden[3] = {-9.81 * bias_rad_, 0.0, 0.0};
    for (int i = 0; i < 3; ++i)
      imu_.acc_m_s2[i] = force[i] + hidden[i] + force_bias_[i] + wrong_.force_noise_m_s2 * random_.normal();
    tracks_ = {imu_.stamp_ns, (1.0 + wrong_.slip) * truth.left_m, (1.0 + wrong_.slip) * truth.right_m, 0};
    flippers_ = {0.5 * (truth.flipper_rad[0] + truth.flipper_rad[1]),
                 0.5 * (truth.flipper_rad[2] + truth.flipper_rad[3])};
  }

  void give(TrackOdometry& odometry) const {
    static_cast<void>(odometry.observe(attitude_));
    if (wrong_.accelerometer) odometry.feel(imu_);
    odometry.set_flippers(flippers_);
    static_cast<void>(odometry.update(tracks_));
  }

  Quaternion q_world_body() const { return rt::to_quaternion(attitude_.q_world_body); }
  double travel_m() const { return 0.5 * (tracks_.left_m + tracks_.right_m); }

 private:
  Disturbance wrong_;
  hil::Random random_;
  double bias_rad_{};
  double force_bias_[3]{};
  double walk_[2]{};
  rt::ImuSample imu_;
  rt::AttitudeEstimate attitude_;
  rt::TrackSample tracks_;
  estimators::FlipperAngles flippers_;
};

/// Rise of a body whose pivot is known, by the sensors' attitude and travel: what no better mode can improve.
double rise_of_pivot(const CourseSample& from, const CourseSample& to, const Quaternion& q_from,
                     const Quaternion& q_to, double travel_m, double run_m) {
  const Quaternion half = rt::slerp(plain(from.q_world_body), plain(to.q_world_body), 0.5);
  const hil::Vec3 moved = to.p_world_m - from.p_world_m;
  const double normal = rotate_back(half, {moved.x, moved.y, moved.z}).z;
  const Vector3 turn = log_rotation(conjugate(q_from) * q_to);
  const bool turns = std::fabs(turn.y) > 0.5 * kTurning_rad_m * std::fabs(travel_m);
  return rotate(q_from * exp_rotation(0.5 * turn), {travel_m - (turns ? turn.y * run_m : 0.0), 0, normal}).z;
}

/// Counts travel in true modes and how much of it was named within the collar.
void score_modes(const std::vector<CourseSample>& drive, const std::vector<int>& truth,
                 const std::vector<std::uint32_t>& named, CourseResult& result) {
  for (std::size_t i = 1; i < drive.size(); ++i) {
    if (truth[i] < 0) continue;
    const double way = std::fabs(travel(drive[i - 1], drive[i]));
    bool hit = false;
    for (std::size_t back = i; back > 0 && std::fabs(travel(drive[back], drive[i])) <= kCollar_m && !hit;
         --back)
      hit = named[back] == static_cast<std::uint32_t>(truth[i]);
    for (std::size_t on = i; on < drive.size() && std::fabs(travel(drive[i], drive[on])) <= kCollar_m && !hit;
         ++on)
      hit = named[on] == static_cast<std::uint32_t>(truth[i]);
    result.mode_m[static_cast<std::size_t>(truth[i])] += way;
    if (hit) result.hit_m[static_cast<std::size_t>(truth[i])] += way;
  }
}

}  // namespace

int true_mode(const CourseSample& from, const CourseSample& s, double direction) {
  const double way = std::fabs(travel(from, s)) + 3e-4;
  const Vector3 turn = log_rotation(conjugate(plain(from.q_world_body)) * plain(s.q_world_body));
  if (std::fabs(turn.y) < kTurning_rad_m * way) return 0;
  double first = -1e9, last = 1e9;
  Vector3 normal;
  for (const SideContacts& side : s.side) {
    if (side.load_n <= 0.0) continue;
    const bool ahead = direction > 0.0;
    const double lead = direction * (ahead ? side.front_x_m : side.rear_x_m);
    if (lead > first) {
      first = lead;
      normal = ahead ? Vector3{side.front_nx, 0, side.front_nz} : Vector3{side.rear_nx, 0, side.rear_nz};
    }
    last = std::min(last, direction * (ahead ? side.rear_x_m : side.front_x_m));
  }
  if (first < last) return -1;
  if (first - last < kOneEdge_m) return 2;
  const double nose_up = -direction * rt::pitch_of(plain(s.q_world_body));
  const bool on_level = rotate(plain(s.q_world_body), normal).z > 0.97;
  if (first > kEnd_m && nose_up < -0.03 && on_level) return direction > 0.0 ? 3 : 1;
  if (last < -kEnd_m) return direction > 0.0 ? 1 : 3;
  return -1;
}

estimators::TrackProfile plant_profile() { return {}; }

CourseResult run_course(const CourseScene& scene, const std::vector<CourseSample>& drive,
                        const Disturbance& wrong, std::uint64_t seed, std::vector<CoursePoint>* path) {
  CourseResult result;
  const double asked = std::fabs(travel(drive.front(), drive.back()));
  const hil::Vec3 gone = drive.back().p_world_m - drive.front().p_world_m;
  result.crossed = std::sqrt(gone.x * gone.x + gone.z * gone.z) > 0.8 * asked || scene.turn_rad_per_m != 0.0;
  TrackOdometryConfig plain_config;
  TrackOdometryConfig config;
  config.obstacles = true;
  estimators::TrackProfile& profile = config.obstacle.modes.profile;
  profile = plant_profile();
  profile.half_length_m *= wrong.length;
  profile.radius_m *= wrong.radius;
  profile.com_x_m += wrong.com_m;
  TrackOdometry perfect(plain_config), standard(plain_config), ours(config);
  Feed clean({}, seed), feed(wrong, seed);
  std::vector<int> truth(drive.size(), -1);
  std::vector<std::uint32_t> named(drive.size());
  const double direction = scene.way_m < 0 ? -1.0 : 1.0;
  double told = 0.0;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Quaternion q_before = feed.q_world_body();
    const double travel_before_m = feed.travel_m();
    clean.next(drive[i]);
    feed.next(drive[i]);
    clean.give(perfect);
    feed.give(standard);
    feed.give(ours);
    named[i] = ours.obstacle().mode;
    if (i == 0) continue;
    truth[i] = true_mode(drive[i - 1], drive[i], direction);
    const double way = std::fabs(travel(drive[i - 1], drive[i]));
    const double z = drive[i].p_world_m.z - drive.front().p_world_m.z;
    const double a = standard.estimate().p_world_body_m[2];
    const double b = ours.estimate().p_world_body_m[2];
    const double c = perfect.estimate().p_world_body_m[2];
    told += rise_of_pivot(drive[i - 1], drive[i], q_before, feed.q_world_body(),
                          feed.travel_m() - travel_before_m, plant_profile().run_m());
    result.pivot += way * (told - z) * (told - z);
    result.way_m += way;
    result.standard += way * (a - z) * (a - z);
    result.ours += way * (b - z) * (b - z);
    result.floor += way * (a - c) * (a - c);
    result.standard_end_m = a - z;
    result.ours_end_m = b - z;
    if (scene.planar && way > 1e-6) {
      result.time_s += drive[i].t_s - drive[i - 1].t_s;
      if (named[i] != 0) result.false_s += drive[i].t_s - drive[i - 1].t_s;
    }
    if (path != nullptr) path->push_back({0.5 * (drive[i].left_m + drive[i].right_m), z, a, b, named[i]});
  }
  score_modes(drive, truth, named, result);
  return result;
}

}  // namespace sortie::bench
