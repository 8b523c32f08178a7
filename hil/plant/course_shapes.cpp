// SPDX-License-Identifier: BSD-3-Clause
// Thirteen families as boxes and cylinders.
#include "hil/plant/course_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hil/plant/obstacles.hpp"

namespace sortie::hil {
namespace {

constexpr double kHalfWidth_m = 1.2;
constexpr double kBehind_m = 2.0;  ///< how far platforms reach behind their edge, and lands beyond the goal
constexpr double kTrackHalf_m = 0.4;  ///< half the vehicle's width and some

/// One course under construction.
struct Shaper {
  Course& course;
  Random& random;
  PlantScene& scene;
  bool uneven;      ///< judging
  double skew_rad;  ///< of edges across the way

  double size(const char* name) const { return course.parameter(name); }
  int count(const char* name) const { return static_cast<int>(rt::floor(size(name) + 0.5)); }
  double side() { return random.chance(0.5) ? 1.0 : -1.0; }

  static void must(Status status) {
    if (status != Status::ok) throw std::runtime_error("hil course: its solids do not fit into a scene");
  }
  /// A box whose middle on the ground is told, turned about the vertical.
  void block(double x, double y, double yaw, double length, double width, double low, double high) {
    must(scene.add_box({x, y, 0.5 * (low + high)}, from_yaw_pitch_roll(yaw, 0.0, 0.0),
                       {0.5 * length, 0.5 * width, 0.5 * (high - low)}));
  }
  /// A box across the way from x = `from` to `to`, turned by the skew about the middle of its first or last
  /// edge, whichever lies at `hinge`.
  void across(double from, double to, double hinge, double low, double high) {
    const rt::SinCos turn = rt::sincos(skew_rad);
    const double arm = 0.5 * (from + to) - hinge;
    block(hinge + arm * turn.cos, arm * turn.sin, skew_rad, to - from, 2.0 * kHalfWidth_m + 2.0, low, high);
  }
  /// Ground the vehicle starts on, up to the first edge.
  void start_platform(double high) {
    across(kCourseLead_m - kBehind_m - 1.0, kCourseLead_m, kCourseLead_m, 0.0, high);
  }
  void end_platform(double from, double high) {
    across(from, from + kCourseTail_m + kBehind_m, from, 0.0, high);
  }
  void goal_after(double last_edge) { course.goal_x_m = last_edge + kCourseTail_m; }

  void posts();
  void waves();
  void rails();
  void stairs(bool up);
  void pallets();
  void rubble();
  void build();
};

void Shaper::posts() {
  constexpr double kField_m = 1.2;
  constexpr double kHalf_m = 0.65;
  const double base = size("height_m");
  const double width = size("side_m");
  const double pitch = width + size("gap_m");
  const double spread = size("spread_m");
  const int along = static_cast<int>(rt::floor(kField_m / pitch));
  const int across_way = static_cast<int>(rt::floor(2.0 * kHalf_m / pitch));
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across_way; ++j) {
      double x = kCourseLead_m + (i + 0.5) * pitch;
      double y = (j - 0.5 * (across_way - 1)) * pitch;
      double yaw = 0.0;
      if (uneven) {
        x += random.uniform(-0.2, 0.2) * size("gap_m");
        y += random.uniform(-0.2, 0.2) * size("gap_m");
        yaw = random.uniform(-0.3, 0.3);
      }
      const double top = base + random.uniform(-0.5, 0.5) * spread;
      block(x, y, yaw, width, width, 0.0, top);
    }
  }
  skew_rad = 0.0;  // platforms are square to the rows
  start_platform(base);
  end_platform(kCourseLead_m + along * pitch, base);
  goal_after(kCourseLead_m + along * pitch);
  course.half_width_m = kHalf_m;
}

void Shaper::waves() {
  constexpr int kFacets = 8;  // of a period
  // Thin: at crests steeper than 45 degrees a facet's end shows, by less than this.
  constexpr double kThick = 0.02;
  const double period = size("period_m");
  const double step = period / kFacets;
  const int periods = static_cast<int>(rt::floor(2.0 / period));
  for (int i = 0; i < periods; ++i) {  // square to the way: a skew would fill the world's cells of the rays
    const double high = size("height_m") * (uneven ? random.uniform(0.8, 1.0) : 1.0);
    const auto rise = [&](int k) { return 0.5 * high * (1.0 - rt::cos(6.283185307179586 / kFacets * k)); };
    for (int k = 0; k < kFacets; ++k) {
      const double low = rise(k);
      const double climb = (k + 1 < kFacets ? rise(k + 1) : 0.0) - low;
      const double length = std::sqrt(step * step + climb * climb);
      must(scene.add_box({kCourseLead_m + i * period + (k + 0.5) * step + 0.5 * kThick * climb / length, 0.0,
                          low + 0.5 * climb - 0.5 * kThick * step / length},
                         from_yaw_pitch_roll(0.0, -rt::atan2(climb, step), 0.0),
                         {0.5 * length, kHalfWidth_m, 0.5 * kThick}));
    }
  }
  goal_after(kCourseLead_m + periods * period);
}

void Shaper::rails() {
  constexpr double kLength_m = 2.4;
  const double angle = side() * size("angle_rad");
  const rt::SinCos turn = rt::sincos(angle);
  const double reach = 0.5 * (kLength_m * turn.cos + size("width_m") * std::fabs(turn.sin));
  const double x = kCourseLead_m + reach;
  const double high = size("height_m");
  // Round bars lie on the ground with all of their height: their width is not drawn for them.
  if (uneven && random.chance(0.5)) {
    must(scene.add_cylinder({x, 0.0, 0.5 * high}, from_yaw_pitch_roll(angle - 1.5707963267948966, 0.0, 0.0),
                            0.5 * high, 0.5 * kLength_m));
    course.obstacle_m -= 0.5 * high;
  } else {
    block(x, 0.0, angle, kLength_m, size("width_m"), 0.0, high);
  }
  goal_after(x + reach);
}

void Shaper::stairs(bool up) {
  const int steps = count("steps");
  const double tread = size("tread_m");
  const double rise = tread * rt::tan(size("angle_rad"));
  double edge[8] = {};
  double top[8] = {};  // of the level that begins or ends at the edge
  double x = kCourseLead_m;
  double z = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double off_tread = uneven ? random.uniform(-0.01, 0.01) : 0.0;
    const double off_rise = uneven ? random.uniform(-0.01, 0.01) : 0.0;
    edge[i] = x;
    z += rise + off_rise;
    top[i] = z;
    x += tread + off_tread;
  }
  const double last = edge[steps - 1];
  for (int i = 0; i < steps; ++i) {
    const double low = i == 0 ? 0.0 : top[i - 1];
    if (up)
      across(edge[i], last + kCourseTail_m + kBehind_m, edge[i], low, top[i]);
    else  // the same stairs from above: the level `i` ends at the edge that is `i` from the last
      across(kCourseLead_m - kBehind_m - 1.0, kCourseLead_m + last - edge[i], kCourseLead_m + last - edge[i],
             low, top[i]);
  }
  goal_after(last);
}

void Shaper::pallets() {
  constexpr double kLength_m = 0.8;
  const int pieces = count("count");
  double x = kCourseLead_m;
  for (int i = 0; i < pieces; ++i) {
    must(add_pallet(scene, {{x, 0.0, 0.0}, uneven ? 0.5 * skew_rad * side() : 0.0}));
    x += kLength_m + (i + 1 < pieces ? size("gap_m") : 0.0);
  }
  goal_after(x);
  course.half_width_m = 0.55;
}

void Shaper::rubble() {
  const double length = size("length_m");
  const int blocks = count("blocks");
  constexpr double kWidth_m = 1.8;
  course.half_width_m = 0.5 * kWidth_m;
  course.obstacle_m = kCourseLead_m - 0.25;
  goal_after(length + kCourseLead_m);
  if (!uneven)
    return must(add_rubble(scene, {{kCourseLead_m, 0.0, 0.0}, 0.0}, length, kWidth_m, blocks, course.seed));
  for (int i = 0; i < blocks; ++i) {  // slabs: larger and flatter than those of add_rubble()
    const double x = random.uniform(kCourseLead_m, kCourseLead_m + length);
    const double y = random.uniform(-0.5 * kWidth_m, 0.5 * kWidth_m);
    const double yaw = random.uniform(-3.14, 3.14);
    const double pitch = random.uniform(-0.4, 0.4);
    const double half_x = random.uniform(0.08, 0.22);
    const double half_y = random.uniform(0.05, 0.16);
    const double half_z = random.uniform(0.02, 0.07);
    must(scene.add_box({x, y, random.uniform(-0.5, 1.0) * half_z}, from_yaw_pitch_roll(yaw, pitch, 0.0),
                       {half_x, half_y, half_z}));
  }
}

void Shaper::build() {
  switch (course.family) {
    case TerrainFamily::step_up:
      end_platform(kCourseLead_m, size("height_m"));
      return goal_after(kCourseLead_m);
    case TerrainFamily::step_down:
      start_platform(size("height_m"));
      return goal_after(kCourseLead_m);
    case TerrainFamily::uplift:
      across(kCourseLead_m, kCourseLead_m + size("length_m"), kCourseLead_m, 0.0, size("height_m"));
      return goal_after(kCourseLead_m + size("length_m"));
    case TerrainFamily::single_step: {
      const double inner = uneven ? random.uniform(-0.1, 0.1) : 0.0;  // its inner edge, from the middle
      const double wide = kHalfWidth_m - inner;
      const double sign = side();
      block(kCourseLead_m + 0.5 * size("length_m"), sign * (inner + 0.5 * wide), 0.0, size("length_m"), wide,
            0.0, size("height_m"));
      return goal_after(kCourseLead_m + size("length_m"));
    }
    case TerrainFamily::posts:
      return posts();
    case TerrainFamily::waves:
      return waves();
    case TerrainFamily::rails:
      return rails();
    case TerrainFamily::stairs_up:
      return stairs(true);
    case TerrainFamily::stairs_down:
      return stairs(false);
    case TerrainFamily::pallets:
      return pallets();
    case TerrainFamily::ramp: {
      const double length = size("length_m");
      must(add_ramp(scene, {{kCourseLead_m, 0.0, 0.0}, skew_rad}, size("slope_rad"), length,
                    kCourseTail_m + kBehind_m, 2.0 * kHalfWidth_m + 1.0));
      return goal_after(kCourseLead_m + length * rt::cos(size("slope_rad")));
    }
    case TerrainFamily::rubble:
      return rubble();
    case TerrainFamily::gap:
      start_platform(size("depth_m"));
      end_platform(kCourseLead_m + size("length_m"), size("depth_m"));
      return goal_after(kCourseLead_m + size("length_m"));
  }
}

}  // namespace

void build_shape(Course& course, Random& random, PlantScene& scene) {
  Shaper shaper{course, random, scene, course.use == CourseUse::judging, 0.0};
  Shaper::must(scene.add_half_space({0, 0, 1}, {0, 0, 0}));
  if (shaper.uneven) {
    course.start_m.y = random.uniform(-0.1, 0.1);
    course.start_yaw_rad = random.uniform(-0.09, 0.09);
    shaper.skew_rad = random.uniform(-0.2, 0.2);
  }
  course.half_width_m = kHalfWidth_m;
  course.obstacle_m = kCourseLead_m - kTrackHalf_m * std::fabs(rt::sin(shaper.skew_rad));
  shaper.build();
}

}  // namespace sortie::hil
