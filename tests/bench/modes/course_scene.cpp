// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/modes/course_scene.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "hil/plant/obstacles.hpp"
#include "hil/random.hpp"

namespace sortie::bench {
namespace {

using hil::PlantScene;
using hil::Quat;
using hil::Vec3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kStand_m = 0.07192;  // of the vehicle's origin above what it stands on
constexpr double kBegin_m = 1.0;      // where obstacles begin

void must(Status status) {
  if (status != Status::ok) throw std::runtime_error("a solid does not fit");
}

std::string text(const char* format, double a, double b = 0.0) {
  char line[80];
  std::snprintf(line, sizeof line, format, a, b);
  return line;
}

void ground(PlantScene& scene) { must(scene.add_half_space({0, 0, 1}, {0, 0, 0})); }

/// A block whose near face is met at (x, y) by one who drives along `yaw`.
void block(PlantScene& scene, double x, double y, double yaw, double length, double width, double height) {
  const Quat q = hil::from_yaw_pitch_roll(yaw, 0, 0);
  must(scene.add_box(Vec3{x, y, 0} + hil::rotate(q, {0.5 * length, 0, 0.5 * height}), q,
                     {0.5 * length, 0.5 * width, 0.5 * height}));
}

/// Draws the scenes of one seed.
class Draw {
 public:
  Draw(std::uint64_t seed, bool folded) : random_(seed, folded ? 7 : 8), folded_(folded) {}

  std::vector<CourseScene> all();

 private:
  CourseScene& add(const char* family, const std::string& sizes, std::function<void(PlantScene&)> build) {
    CourseScene scene;
    scene.family = family;
    scene.name = std::string(family) + " " + sizes + (folded_ ? ", folded" : "");
    scene.build = [build = std::move(build)](PlantScene& s) {
      ground(s);
      build(s);
    };
    const double used[4] = {0.6, 0.6, 0.1, 0.1};
    for (int f = 0; f < hil::kFlippers; ++f) scene.flipper_rad[f] = folded_ ? 2.7 : used[f];
    scenes_.push_back(std::move(scene));
    return scenes_.back();
  }
  void flats_and_slopes();
  void steps();
  void stairs();
  void rough();

  hil::Random random_;
  bool folded_;
  std::vector<CourseScene> scenes_;
};

void Draw::flats_and_slopes() {
  const double turn = random_.uniform(-0.5, 0.5);
  CourseScene& flat = add("flat", text("%.2f rad/m", turn), [](PlantScene&) {});
  flat.turn_rad_per_m = turn;
  flat.planar = true;
  const double incline = random_.uniform(0.15, 0.6);
  CourseScene& slope = add("slope", text("%.0f deg", incline * 180 / kPi),
                           [incline](PlantScene& s) { must(hil::add_ramp(s, {}, incline, 8.0, 1.0, 2.0)); });
  slope.start_q_world_body = hil::from_yaw_pitch_roll(0, -incline, 0);
  slope.start_m = hil::rotate(slope.start_q_world_body, {1.5, 0, kStand_m});
  slope.planar = true;
  for (const bool down : {false, true}) {
    const double angle = random_.uniform(0.17, 0.61);
    const double length = random_.uniform(1.0, 1.6);
    const double foot = length * rt::sincos(angle).cos;
    CourseScene& ramp =
        add(down ? "ramp down" : "ramp up", text("%.0f deg", angle * 180 / kPi), [=](PlantScene& s) {
          const hil::Approach up{{kBegin_m, 0, 0}, 0.0};
          const hil::Approach back{{kBegin_m + foot, 0, 0}, kPi};
          must(hil::add_ramp(s, down ? back : up, angle, length, 2.5, 2.0));
        });
    if (down) ramp.start_m.z += length * rt::sincos(angle).sin;
    ramp.way_m = 2.4 + length;
  }
}

void Draw::steps() {
  const double up = random_.uniform(0.04, folded_ ? 0.07 : 0.17);
  add("step up", text("%.0f cm", 100 * up), [up](PlantScene& s) { block(s, kBegin_m, 0, 0, 3, 2, up); });
  const double down = random_.uniform(0.05, 0.2);
  CourseScene& drop = add("drop", text("%.0f cm", 100 * down),
                          [down](PlantScene& s) { block(s, kBegin_m, 0, kPi, 3, 2, down); });
  drop.start_m.z += down;
  const double high = random_.uniform(0.03, folded_ ? 0.06 : 0.1);
  const double long_m = random_.uniform(0.15, 1.3);
  add("block", text("%.0f x %.0f cm", 100 * high, 100 * long_m),
      [=](PlantScene& s) { block(s, kBegin_m, 0, 0, long_m, 2, high); });
  CourseScene& backwards = add("backwards", text("%.0f x %.0f cm", 100 * high, 100 * long_m),
                               [=](PlantScene& s) { block(s, -kBegin_m, 0, kPi, long_m, 2, high); });
  backwards.way_m = -3.0;
  std::swap(backwards.flipper_rad[0], backwards.flipper_rad[2]);
  std::swap(backwards.flipper_rad[1], backwards.flipper_rad[3]);
  if (!folded_) add("pallet", "", [](PlantScene& s) { must(hil::add_pallet(s, {{kBegin_m, 0, 0}, 0})); });
}

void Draw::stairs() {
  const double rise = random_.uniform(0.14, 0.18);
  const double run = random_.uniform(0.26, 0.32);
  const int count = 4;
  hil::StairShape shape;
  shape.steps = count;
  shape.run_m = run;
  shape.rise_m = rise;
  shape.landing_m = 2.5;
  if (!folded_) {
    CourseScene& up = add("stairs up", text("%.0f / %.0f cm", 100 * rise, 100 * run), [=](PlantScene& s) {
      must(hil::add_stairs(s, {{kBegin_m, 0, 0}, 0}, shape));
    });
    up.friction = 1.2;
    up.way_m = 3.8;
  }
  CourseScene& down = add("stairs down", text("%.0f / %.0f cm", 100 * rise, 100 * run), [=](PlantScene& s) {
    must(hil::add_stairs(s, {{kBegin_m + run * (count - 1), 0, 0}, kPi}, shape));
  });
  down.start_m.z += rise * count;
  down.friction = 1.0;
  down.way_m = 3.4;
}

void Draw::rough() {
  const auto seed = static_cast<std::uint64_t>(random_.bits() >> 40);
  add("rubble", "seed " + std::to_string(seed), [seed](PlantScene& s) {
    must(hil::add_rubble(s, {{0.7, 0, 0}, 0}, 2.5, 1.2, 40, seed));
  });
  const double yaw = random_.uniform(0.3, 0.75) * (random_.chance(0.5) ? 1 : -1);
  const double oblique = random_.uniform(0.03, 0.08);
  add("oblique", text("%.0f cm at %.0f deg", 100 * oblique, yaw * 180 / kPi),
      [=](PlantScene& s) { block(s, kBegin_m, 0, yaw, 0.7, 4, oblique); });
  const double side = random_.uniform(0.03, 0.08);
  const double left = random_.chance(0.5) ? 1 : -1;
  add("one track", text("%.0f cm", 100 * side),
      [=](PlantScene& s) { block(s, kBegin_m, 0.35 * left, 0, 0.8, 0.6, side); });
}

std::vector<CourseScene> Draw::all() {
  flats_and_slopes();
  steps();
  stairs();
  rough();
  return std::move(scenes_);
}

}  // namespace

std::vector<CourseScene> course_scenes(std::uint64_t seed) {
  std::vector<CourseScene> scenes = Draw(seed, true).all();
  std::vector<CourseScene> used = Draw(seed, false).all();
  scenes.insert(scenes.end(), used.begin(), used.end());
  return scenes;
}

}  // namespace sortie::bench
