// SPDX-License-Identifier: BSD-3-Clause
// Buildings of solid boxes, and the clouds that a lidar on the ground and a camera in the air make of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "rt/rotation.hpp"
#include "tests/mapping/world_random.hpp"

namespace sortie::tests {

/// A box, turned at will; a shell is seen from inside.
struct SolidBox {
  rt::Vector3 middle_m;
  rt::Vector3 half_m;
  rt::RotationMatrix turn;
  bool textured[6]{};  ///< by face: -x, +x, -y, +y, -z, +z
  bool shell{};
};

/// What a ray meets.
struct FaceHit {
  double range_m{1e9};
  std::uint32_t face{};  ///< 6 x box + face
  rt::Vector3 normal;    ///< to the side that the ray comes from
};

/// A point of a cloud, and where it was seen from.
struct SeenPoint {
  rt::Vector3 at_m;
  rt::Vector3 from_m;
};

/// Rooms, boxes and ramps.
struct Building {
  std::vector<SolidBox> boxes;
  rt::Vector3 size_m;

  void add(WorldRandom& random, const rt::Vector3& middle, const rt::Vector3& half, const rt::Quaternion& q,
           bool shell = false) {
    SolidBox box{middle, half, rt::to_matrix(q), {}, shell};
    for (bool& textured : box.textured) textured = random.below(10) < 6;
    boxes.push_back(box);
  }
  FaceHit hit(const rt::Vector3& from, const rt::Vector3& ray) const;
  bool free(const rt::Vector3& x, double margin_m) const;
};

/// Parts of `x` along a box's axes.
inline void in_axes(const SolidBox& box, const rt::Vector3& x, double (&out)[3]) {
  for (int k = 0; k < 3; ++k)
    out[k] = box.turn.m[k] * x.x + box.turn.m[3 + k] * x.y + box.turn.m[6 + k] * x.z;
}

inline rt::Vector3 axis_of(const SolidBox& box, int k) {
  return {box.turn.m[k], box.turn.m[3 + k], box.turn.m[6 + k]};
}

inline FaceHit Building::hit(const rt::Vector3& from, const rt::Vector3& ray) const {
  FaceHit best;
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    const SolidBox& box = boxes[b];
    double o[3], d[3];
    in_axes(box, from - box.middle_m, o);
    in_axes(box, ray, d);
    const double half[3] = {box.half_m.x, box.half_m.y, box.half_m.z};
    double near = -1e9, far = 1e9;
    int near_axis = 0, far_axis = 0;
    for (int k = 0; k < 3; ++k) {
      const double step = std::fabs(d[k]) < 1e-12 ? 1e-12 : d[k];
      const double a = (-half[k] - o[k]) / step, c = (half[k] - o[k]) / step;
      if (std::min(a, c) > near) near = std::min(a, c), near_axis = k;
      if (std::max(a, c) < far) far = std::max(a, c), far_axis = k;
    }
    const double range = box.shell ? far : near;
    if (near > far || range < 1e-6 || range >= best.range_m) continue;
    const int axis = box.shell ? far_axis : near_axis;
    const bool plus = (d[axis] > 0.0) == box.shell;
    best = {range,
            static_cast<std::uint32_t>(6 * b) + 2 * static_cast<std::uint32_t>(axis) + (plus ? 1u : 0u),
            (d[axis] > 0.0 ? -1.0 : 1.0) * axis_of(box, axis)};
  }
  return best;
}

inline bool Building::free(const rt::Vector3& x, double margin_m) const {
  for (const SolidBox& box : boxes) {
    double o[3];
    in_axes(box, x - box.middle_m, o);
    const double m = box.shell ? -margin_m : margin_m;
    const bool inside = std::fabs(o[0]) < box.half_m.x + m && std::fabs(o[1]) < box.half_m.y + m &&
                        std::fabs(o[2]) < box.half_m.z + m;
    if (inside != box.shell) return false;
  }
  return true;
}

/// Halls of 14 to 34 m with walls inside, boxes (some turned) and ramps.
inline Building random_building(WorldRandom& random) {
  Building out;
  const double x = random.between(14, 34), y = random.between(10, 22), z = random.between(4, 8);
  out.size_m = {x, y, z};
  out.add(random, 0.5 * out.size_m, 0.5 * out.size_m, {}, true);
  const std::uint32_t walls = 2 + random.below(3);
  for (std::uint32_t k = 0; k < walls; ++k) {
    const bool along_x = random.below(2) == 0;
    const double half = random.between(1.5, 0.25 * (along_x ? x : y)), up = random.between(1.2, 0.45 * z);
    const double thick = random.between(0.1, 0.3);
    const rt::Vector3 at{random.between(3, x - 3), random.between(3, y - 3), up};
    out.add(random, at, along_x ? rt::Vector3{half, thick, up} : rt::Vector3{thick, half, up}, {});
  }
  const std::uint32_t things = 5 + random.below(7);
  for (std::uint32_t k = 0; k < things; ++k) {
    const double yaw = random.below(3) == 0 ? random.between(0, 1.57) : 0.0;
    const double a = random.between(0.6, 2), b = random.between(0.6, 2), h = random.between(0.4, 1.2);
    const rt::Vector3 at{random.between(2, x - 2), random.between(2, y - 2), h};
    out.add(random, at, {a, b, h}, rt::from_yaw_pitch_roll(yaw, 0, 0));
  }
  const std::uint32_t ramps = random.below(3);
  for (std::uint32_t k = 0; k < ramps; ++k) {
    const double yaw = 1.5707963267948966 * random.below(4), pitch = random.between(0.2, 0.45);
    const rt::Vector3 at{random.between(4, x - 4), random.between(4, y - 4), 0};
    out.add(random, at, {2.5, 1.2, 0.5}, rt::from_yaw_pitch_roll(yaw, pitch, 0));
  }
  return out;
}

/// A place between two shares of the building's length, and two heights.
inline rt::Vector3 free_place(const Building& in, double from, double to, double low_m, double high_m,
                              WorldRandom& random) {
  for (int k = 0; k < 200; ++k) {
    const double x = random.between(from, to) * in.size_m.x;
    const double y = random.between(0.1, 0.9) * in.size_m.y;
    const rt::Vector3 at{x, y, random.between(low_m, high_m)};
    if (in.free(at, 0.4)) return at;
  }
  return {0.5 * (from + to) * in.size_m.x, 0.5 * in.size_m.y, high_m};
}

/// Six scans of 32 rows from 0.7 m above the floor, 1 cm of noise, 20 m far.
inline std::vector<SeenPoint> ground_cloud(const Building& in, double from, double to, WorldRandom& random) {
  std::vector<SeenPoint> out;
  for (int scan = 0; scan < 6; ++scan) {
    const rt::Vector3 at = free_place(in, from, to, 0.6, 0.8, random);
    for (int row = 0; row < 32; ++row) {
      const double up = -0.5 + 1.1 * row / 31;
      for (int column = 0; column < 360; ++column) {
        const double turn = (column + 0.5) / 57.29577951308232;
        const rt::Vector3 ray{std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)};
        const FaceHit hit = in.hit(at, ray);
        if (hit.range_m < 20.0) out.push_back({at + (hit.range_m + 0.01 * random.normal()) * ray, at});
      }
    }
  }
  return out;
}

/// Clumps of 25 points before surfaces: `share` of the cloud.
inline void add_clumps(std::vector<SeenPoint>& cloud, double share, WorldRandom& random) {
  const auto count = static_cast<std::size_t>(share * static_cast<double>(cloud.size())) / 25;
  const auto real = static_cast<std::uint32_t>(cloud.size());
  for (std::size_t k = 0; k < count; ++k) {
    const SeenPoint behind = cloud[random.below(real)];
    const rt::Vector3 middle = behind.from_m + random.between(0.4, 0.9) * (behind.at_m - behind.from_m);
    for (int i = 0; i < 25; ++i) {
      const double x = 0.15 * random.normal(), y = 0.15 * random.normal();
      cloud.push_back({middle + rt::Vector3{x, y, 0.15 * random.normal()}, behind.from_m});
    }
  }
}

/// A camera that looks down from the upper part of the building: 60 views of 70 by 50 degrees. Only faces
/// with texture, 1 % of the range as noise, nothing where points would be more than 0.3 m apart, 2 % clumps.
inline std::vector<SeenPoint> air_cloud(const Building& in, double from, double to, WorldRandom& random) {
  std::vector<SeenPoint> out;
  constexpr int kColumns = 64, kRows = 46;
  constexpr double kStep_rad = 0.019;
  for (int view = 0; view < 60; ++view) {
    const rt::Vector3 at = free_place(in, from, to, 0.55 * in.size_m.z, 0.85 * in.size_m.z, random);
    const double yaw = random.between(-3.14, 3.14);
    const rt::Quaternion q = rt::from_yaw_pitch_roll(yaw, random.between(0.25, 1.0), 0);
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const double a = kStep_rad * (column - 0.5 * kColumns), b = kStep_rad * (row - 0.5 * kRows);
        const rt::Vector3 ray = rt::rotate(q, (1.0 / std::sqrt(1 + a * a + b * b)) * rt::Vector3{1, a, b});
        const FaceHit hit = in.hit(at, ray);
        if (!in.boxes[hit.face / 6].textured[hit.face % 6]) continue;
        if (hit.range_m * kStep_rad > 0.3 * std::fabs(rt::dot(ray, hit.normal))) continue;
        out.push_back({at + (hit.range_m * (1.0 + 0.01 * random.normal())) * ray, at});
      }
    }
  }
  add_clumps(out, 0.02, random);
  return out;
}

}  // namespace sortie::tests
