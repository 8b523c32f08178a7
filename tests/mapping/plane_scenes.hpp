// SPDX-License-Identifier: BSD-3-Clause
// Halls as planes, seen twice with errors that are known: what the registration of planes is tried on.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping/registration/plane.hpp"
#include "mapping/registration/plane_pose.hpp"
#include "rt/rotation.hpp"
#include "tests/mapping/world_random.hpp"

namespace sortie::tests {

/// A rectangle with middle `c`, normal `n` and first side along `u` (need not be exact), of 2 hu by 2 hv.
inline mapping::Plane rectangle(const rt::Vector3& n, const rt::Vector3& c, const rt::Vector3& u, double hu,
                                double hv) {
  mapping::Plane p;
  p.normal = (1.0 / rt::norm(n)) * n;
  const rt::Vector3 side = u - rt::dot(u, p.normal) * p.normal;
  p.axis_u = (1.0 / rt::norm(side)) * side;
  p.centroid_m = c;
  p.offset_m = rt::dot(p.normal, c);
  p.least_m[0] = -hu, p.most_m[0] = hu;
  p.least_m[1] = -hv, p.most_m[1] = hv;
  p.area_m2 = 4 * hu * hv;
  p.sigma_offset_m = 1e-3;
  p.sigma_tilt_rad[0] = p.sigma_tilt_rad[1] = 1e-3;
  return p;
}

/// Walls, floors and boxes of a building.
class HallMaker {
 public:
  HallMaker(WorldRandom& random, double x_m, double y_m, double z_m)
      : random_(random), size_{x_m, y_m, z_m} {}

  void shell() {
    const double x = size_.x, y = size_.y, z = size_.z;
    add({0, 0, 1}, {x / 2, y / 2, 0}, {1, 0, 0}, x / 2, y / 2);
    add({0, 0, -1}, {x / 2, y / 2, z}, {1, 0, 0}, x / 2, y / 2);
    add({1, 0, 0}, {0, y / 2, z / 2}, {0, 1, 0}, y / 2, z / 2);
    add({-1, 0, 0}, {x, y / 2, z / 2}, {0, 1, 0}, y / 2, z / 2);
    add({0, 1, 0}, {x / 2, 0, z / 2}, {1, 0, 0}, x / 2, z / 2);
    add({0, -1, 0}, {x / 2, y, z / 2}, {1, 0, 0}, x / 2, z / 2);
  }
  /// A wall inside, with one or both faces.
  void inner_wall() {
    const bool along_x = random_.below(2) == 0;
    const double half = random_.between(1.0, 0.3 * (along_x ? size_.x : size_.y));
    const double z = random_.between(1.0, 0.5 * size_.z);
    const rt::Vector3 c{random_.between(1, size_.x - 1), random_.between(1, size_.y - 1), z};
    const rt::Vector3 n = along_x ? rt::Vector3{0, 1, 0} : rt::Vector3{1, 0, 0};
    const rt::Vector3 u = along_x ? rt::Vector3{1, 0, 0} : rt::Vector3{0, 1, 0};
    const std::uint32_t faces = random_.below(3);
    if (faces != 1) add(n, c + 0.1 * n, u, half, z);
    if (faces != 0) add(-1.0 * n, c - 0.1 * n, u, half, z);
  }
  /// A machine or a crate: top and up to four sides, turned at will when `turned`.
  void box(bool turned) {
    const double yaw = turned ? random_.between(0, 1.57) : 0.0;
    const rt::Vector3 ex{std::cos(yaw), std::sin(yaw), 0};
    const rt::Vector3 ey{-std::sin(yaw), std::cos(yaw), 0};
    const double a = random_.between(0.5, 2.5), b = random_.between(0.5, 2.5), h = random_.between(0.5, 2.0);
    const rt::Vector3 c{random_.between(2, size_.x - 2), random_.between(2, size_.y - 2), 0};
    add({0, 0, 1}, c + rt::Vector3{0, 0, h}, ex, a, b);
    const rt::Vector3 mid = c + rt::Vector3{0, 0, h / 2};
    if (random_.below(3) != 0) add(ex, mid + a * ex, ey, b, h / 2);
    if (random_.below(3) != 0) add(-1.0 * ex, mid - a * ex, ey, b, h / 2);
    if (random_.below(3) != 0) add(ey, mid + b * ey, ex, a, h / 2);
    if (random_.below(3) != 0) add(-1.0 * ey, mid - b * ey, ex, a, h / 2);
  }
  /// A pitched roof's side or a ramp.
  void slope() {
    const double yaw = 1.5707963267948966 * random_.below(4);
    const double pitch = random_.between(0.3, 0.7);
    const rt::Vector3 n{std::cos(yaw) * std::sin(pitch), std::sin(yaw) * std::sin(pitch), std::cos(pitch)};
    add(n, {random_.between(2, size_.x - 2), random_.between(2, size_.y - 2), random_.between(0, size_.z)},
        {-std::sin(yaw), std::cos(yaw), 0}, random_.between(1, 4), random_.between(1, 4));
  }
  /// Fills up to `count` planes: inner walls, boxes, and now and then a slope.
  void furnish(std::size_t count) {
    while (planes.size() < count) {
      const std::uint32_t kind = random_.below(10);
      if (kind < 5)
        inner_wall();
      else if (kind < 9)
        box(kind == 8);
      else
        slope();
    }
    planes.resize(count);
  }
  const rt::Vector3& size() const { return size_; }

  std::vector<mapping::Plane> planes;

 private:
  void add(const rt::Vector3& n, const rt::Vector3& c, const rt::Vector3& u, double hu, double hv) {
    planes.push_back(rectangle(n, c, u, hu, hv));
  }
  WorldRandom& random_;
  rt::Vector3 size_;
};

/// Errors of a sensor's planes, as standard deviations; 0: exact.
struct PlaneNoise {
  double offset_m{0.015};
  double tilt_rad{0.006};
  double least_seen{0.6};  ///< of each side of a rectangle
};

/// A plane as a sensor sees it: a part of the rectangle, shifted and tilted. Larger planes are surer: tilt
/// falls with the square root of the length, to a third at most.
inline mapping::Plane seen(const mapping::Plane& truth, const PlaneNoise& noise, WorldRandom& random) {
  mapping::Plane p = truth;
  const rt::Vector3 v = truth.axis_v();
  double half[2];
  double middle[2];
  for (int k = 0; k < 2; ++k) {
    const double side = truth.most_m[k] - truth.least_m[k];
    const double part = random.between(noise.least_seen, 1.0) * side;
    half[k] = part / 2;
    middle[k] = truth.least_m[k] + half[k] + random.between(0, side - part);
  }
  const auto tilt = [&](double half_side) {
    return noise.tilt_rad * std::clamp(1.0 / std::sqrt(half_side), 1.0 / 3.0, 1.5);
  };
  const double about_u = std::max(1e-6, tilt(half[1]));
  const double about_v = std::max(1e-6, tilt(half[0]));
  const double a = noise.tilt_rad > 0 ? about_u * random.normal() : 0.0;
  const double b = noise.tilt_rad > 0 ? about_v * random.normal() : 0.0;
  const double d = noise.offset_m * random.normal();
  const rt::Vector3 c = truth.centroid_m + middle[0] * truth.axis_u + middle[1] * v + d * truth.normal;
  const rt::Quaternion turn = rt::exp_rotation(a * truth.axis_u + b * v);
  p = rectangle(rt::rotate(turn, truth.normal), c, rt::rotate(turn, truth.axis_u), half[0], half[1]);
  p.sigma_offset_m = std::max(1e-6, noise.offset_m);
  p.sigma_tilt_rad[0] = about_u;
  p.sigma_tilt_rad[1] = about_v;
  return p;
}

/// A plane of the target's frame in the source's.
inline mapping::Plane carried(const mapping::Plane& p, const mapping::PlanePose& T_to_from) {
  mapping::Plane out = p;
  const double s = T_to_from.scale;
  out.normal = rt::rotate(T_to_from.q_target_source, p.normal);
  out.axis_u = rt::rotate(T_to_from.q_target_source, p.axis_u);
  out.centroid_m = mapping::transform(T_to_from, p.centroid_m);
  out.offset_m = rt::dot(out.normal, out.centroid_m);
  for (int k = 0; k < 2; ++k) out.least_m[k] *= s, out.most_m[k] *= s;
  out.area_m2 *= s * s;
  out.sigma_offset_m *= s;
  return out;
}

/// Two views of one place.
struct PlaneScene {
  mapping::PlaneSet source;
  mapping::PlaneSet target;
  mapping::PlanePose truth;  ///< T_target_source
  std::uint32_t common{};
};

inline mapping::PlanePose random_pose(WorldRandom& random, double most_m, double scale) {
  mapping::PlanePose pose;
  pose.q_target_source = rt::from_yaw_pitch_roll(random.between(-3.14, 3.14), 0, 0);
  const double x = random.between(-most_m, most_m);
  const double y = random.between(-most_m, most_m);
  pose.p_target_source_m = {x, y, random.between(-5, 5)};
  pose.scale = scale;
  return pose;
}

/// Puts what both see, and what one alone sees, into a scene: `common` planes are seen by both with their
/// own errors.
inline PlaneScene make_scene(const std::vector<mapping::Plane>& common,
                             const std::vector<mapping::Plane>& source_only,
                             const std::vector<mapping::Plane>& target_only, const mapping::PlanePose& truth,
                             const PlaneNoise& source_noise, const PlaneNoise& target_noise,
                             WorldRandom& random) {
  PlaneScene scene;
  scene.truth = truth;
  scene.common = static_cast<std::uint32_t>(common.size());
  const mapping::PlanePose back = mapping::inverse(truth);
  std::vector<mapping::Plane> source;
  std::vector<mapping::Plane> target;
  for (const mapping::Plane& p : common) {
    target.push_back(seen(p, target_noise, random));
    source.push_back(carried(seen(p, source_noise, random), back));
  }
  for (const mapping::Plane& p : source_only) source.push_back(carried(seen(p, source_noise, random), back));
  for (const mapping::Plane& p : target_only) target.push_back(seen(p, target_noise, random));
  random.shuffle(source);
  random.shuffle(target);
  std::uint32_t id = 0;
  for (mapping::Plane p : source) p.id = id++, (void)scene.source.push_back(p);
  for (mapping::Plane p : target) p.id = id++, (void)scene.target.push_back(p);
  return scene;
}

/// A random hall in which `common` planes are seen by both, and each sees others alone. The six of the shell
/// are among the common ones where there is room, else three of them that show all directions.
inline PlaneScene random_scene(std::uint32_t common, std::uint32_t source_only, std::uint32_t target_only,
                               double scale, const PlaneNoise& source_noise, const PlaneNoise& target_noise,
                               WorldRandom& random) {
  HallMaker hall(random, random.between(15, 60), random.between(10, 30), random.between(4, 9));
  hall.shell();
  hall.furnish(common + source_only + target_only + 6);
  std::vector<mapping::Plane> shell(hall.planes.begin(), hall.planes.begin() + 6);
  std::vector<mapping::Plane> rest(hall.planes.begin() + 6, hall.planes.end());
  random.shuffle(rest);
  std::vector<mapping::Plane> both;
  if (common >= 10) {
    both = shell;
  } else {  // one floor, one wall each way
    both = {shell[random.below(2)], shell[2 + random.below(2)], shell[4 + random.below(2)]};
  }
  std::size_t next = 0;
  while (both.size() < common) both.push_back(rest[next++]);
  const auto take = [&](std::uint32_t n) {
    std::vector<mapping::Plane> out(rest.begin() + static_cast<std::ptrdiff_t>(next),
                                    rest.begin() + static_cast<std::ptrdiff_t>(next + n));
    next += n;
    return out;
  };
  const std::vector<mapping::Plane> from = take(source_only);
  const std::vector<mapping::Plane> to = take(target_only);
  const mapping::PlanePose truth = random_pose(random, 30, scale);
  return make_scene(both, from, to, truth, source_noise, target_noise, random);
}

/// A hall that half a turn about its middle takes into itself, `extra` planes on each side aside.
inline PlaneScene symmetric_scene(std::uint32_t planes, std::uint32_t extra, WorldRandom& random) {
  HallMaker hall(random, random.between(10, 40), random.between(8, 25), random.between(3, 8));
  hall.shell();
  hall.furnish(6 + (planes - std::min(planes, 6u)) / 2);
  const rt::Vector3 size = hall.size();
  std::vector<mapping::Plane> both = hall.planes;
  for (std::size_t i = 6; i < hall.planes.size(); ++i) {
    const mapping::Plane& p = hall.planes[i];
    both.push_back(rectangle({-p.normal.x, -p.normal.y, p.normal.z},
                             {size.x - p.centroid_m.x, size.y - p.centroid_m.y, p.centroid_m.z},
                             {-p.axis_u.x, -p.axis_u.y, p.axis_u.z}, p.most_m[0], p.most_m[1]));
  }
  HallMaker other(random, size.x, size.y, size.z);
  other.furnish(2 * extra);
  const std::vector<mapping::Plane> from(other.planes.begin(), other.planes.begin() + extra);
  const std::vector<mapping::Plane> to(other.planes.begin() + extra, other.planes.end());
  return make_scene(both, from, to, random_pose(random, 30, 1.0), {}, {0.01, 0.004, 0.6}, random);
}

/// A hall, and its mirror image: no pose is right.
inline PlaneScene mirrored_scene(std::uint32_t planes, WorldRandom& random) {
  HallMaker hall(random, random.between(10, 40), random.between(8, 25), random.between(3, 8));
  hall.shell();
  hall.furnish(planes);
  std::vector<mapping::Plane> image;
  for (const mapping::Plane& p : hall.planes)
    image.push_back(rectangle({-p.normal.x, p.normal.y, p.normal.z},
                              {-p.centroid_m.x, p.centroid_m.y, p.centroid_m.z},
                              {-p.axis_u.x, p.axis_u.y, p.axis_u.z}, p.most_m[0], p.most_m[1]));
  return make_scene({}, hall.planes, image, random_pose(random, 30, 1.0), {}, {0.01, 0.004, 0.6}, random);
}

/// Two halls of one kind: the same height of storeys, now and then the same width.
inline PlaneScene wrong_building_scene(std::uint32_t source, std::uint32_t target, WorldRandom& random) {
  const double x = random.between(10, 40), y = random.between(8, 25), z = random.between(3, 8);
  HallMaker first(random, x, y, z);
  const bool same_width = random.below(3) == 0;
  HallMaker second(random, random.between(10, 40), same_width ? y : random.between(8, 25), z);
  for (HallMaker* hall : {&first, &second}) hall->shell();
  first.furnish(source);
  second.furnish(target);
  return make_scene({}, first.planes, second.planes, random_pose(random, 30, 1.0), {}, {0.01, 0.004, 0.6},
                    random);
}

/// How far a pose is off: at the middle of the source's planes, and in angle.
struct PoseError {
  double position_m;
  double angle_rad;
  double scale;
};

inline rt::Vector3 middle_of(const mapping::PlaneSet& planes) {
  rt::Vector3 sum;
  for (const mapping::Plane& p : planes) sum = sum + (1.0 / planes.size()) * p.centroid_m;
  return sum;
}

inline PoseError pose_error(const PlaneScene& scene, const mapping::PlanePose& pose) {
  const rt::Vector3 at = middle_of(scene.source);
  return {rt::norm(mapping::transform(pose, at) - mapping::transform(scene.truth, at)),
          rt::norm(rt::log_rotation(pose.q_target_source * rt::conjugate(scene.truth.q_target_source))),
          std::fabs(pose.scale / scene.truth.scale - 1.0)};
}

}  // namespace sortie::tests
