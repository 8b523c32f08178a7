// SPDX-License-Identifier: BSD-3-Clause
// The ranges of each family, and how a course's sizes are drawn from them.
#include "hil/plant/course_families.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "hil/plant/course_heights.hpp"
#include "hil/plant/course_shapes.hpp"
#include "rt/digest.hpp"

namespace sortie::hil {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kBodyHeight_m = 0.07192;  ///< of the body's origin over level ground

constexpr CourseRange kCommon[] = {
    {"friction", 0.3, 1.0, 0}, {"load_kg", 0.0, 8.0, 0}, {"load_height_m", 0.15, 0.35, 0}};
constexpr CourseRange kStepUp[] = {{"height_m", 0.05, 0.4, 1}};
constexpr CourseRange kStepDown[] = {{"height_m", 0.05, 0.6, 1}};
constexpr CourseRange kUplift[] = {{"height_m", 0.05, 0.4, 1}, {"length_m", 0.2, 0.5, -1}};
constexpr CourseRange kSingleStep[] = {{"height_m", 0.05, 0.3, 1}, {"length_m", 0.3, 0.8, 0}};
constexpr CourseRange kPosts[] = {
    {"height_m", 0.2, 0.5, 0}, {"spread_m", 0.0, 0.15, 1}, {"gap_m", 0.05, 0.2, 1}, {"side_m", 0.1, 0.2, -1}};
constexpr CourseRange kWaves[] = {{"height_m", 0.1, 0.4, 1}, {"period_m", 0.25, 1.0, 0}};
constexpr CourseRange kRails[] = {
    {"height_m", 0.05, 0.3, 1}, {"angle_rad", 10 * kDegree, 45 * kDegree, 0}, {"width_m", 0.05, 0.15, 0}};
constexpr CourseRange kStairs[] = {
    {"angle_rad", 20 * kDegree, 45 * kDegree, 1}, {"tread_m", 0.2, 0.3, 0}, {"steps", 3.0, 6.0, 0}};
constexpr CourseRange kPallets[] = {{"count", 1.0, 3.0, 1}, {"gap_m", 0.0, 0.3, 1}};
constexpr CourseRange kRamp[] = {{"slope_rad", 5 * kDegree, 40 * kDegree, 1}, {"length_m", 0.8, 2.0, 0}};
constexpr CourseRange kRubble[] = {{"blocks", 15.0, 60.0, 1}, {"length_m", 1.0, 2.0, 0}};
constexpr CourseRange kGap[] = {{"length_m", 0.1, 0.45, 1}, {"depth_m", 0.2, 0.6, 0}};

struct FamilyRow {
  const char* name;
  std::span<const CourseRange> ranges;
};
constexpr FamilyRow kFamilies[kTerrainFamilies] = {{"step-up", kStepUp},
                                                   {"step-down", kStepDown},
                                                   {"uplift", kUplift},
                                                   {"one-side", kSingleStep},
                                                   {"posts", kPosts},
                                                   {"waves", kWaves},
                                                   {"rails", kRails},
                                                   {"stairs-up", kStairs},
                                                   {"stairs-down", kStairs},
                                                   {"pallets", kPallets},
                                                   {"ramp", kRamp},
                                                   {"rubble", kRubble},
                                                   {"gap", kGap}};

const FamilyRow& row(TerrainFamily family) {
  const auto index = static_cast<unsigned>(family);
  if (index >= kTerrainFamilies) throw std::runtime_error("hil course: there is no such family");
  return kFamilies[index];
}

/// Where in its range a size lies, 0..1.
double draw_share(CourseUse use, const CourseRange& range, double difficulty, Random& random) {
  const double one = random.uniform();
  if (range.harder == 0) return one;
  const double other = random.uniform();
  const double aim = range.harder > 0 ? difficulty : 1.0 - difficulty;
  // Tuning: evenly within 0.15. Judging: a triangle twice as wide, its peak at the difficulty.
  const double off = use == CourseUse::tuning ? 0.3 * (one - 0.5) : 0.3 * (one + other - 1.0);
  return std::clamp(aim + off, 0.0, 1.0);
}

}  // namespace

const char* name_of(TerrainFamily family) { return row(family).name; }

std::span<const CourseRange> common_ranges() { return kCommon; }

std::span<const CourseRange> ranges_of(TerrainFamily family) { return row(family).ranges; }

double Course::parameter(std::string_view name) const {
  for (const CourseParameter& p : parameters)
    if (name == p.name) return p.value;
  throw std::runtime_error("hil course: " + std::string(name_of(family)) + " has no " + std::string(name));
}

double Course::height(double x_m, double y_m) const { return upper_height(*scene, x_m, y_m); }

Course draw_course(CourseUse use, TerrainFamily family, std::uint64_t seed, double difficulty) {
  if (!(difficulty >= 0.0 && difficulty <= 1.0))
    throw std::runtime_error("hil course: difficulty lies in 0..1");
  const FamilyRow& drawn = row(family);
  const std::uint64_t stream = use == CourseUse::tuning ? 0x74756e65 : 0x6a756467;
  Random random(seed, stream + (static_cast<std::uint64_t>(family) << 32));
  Course course;
  course.family = family;
  course.use = use;
  course.seed = seed;
  course.difficulty = difficulty;
  const auto draw = [&](std::span<const CourseRange> ranges) {
    for (const CourseRange& range : ranges) {
      const double share = draw_share(use, range, difficulty, random);
      if (!course.parameters.push_back({range.name, range.low + share * (range.high - range.low)}))
        throw std::runtime_error("hil course: too many sizes");
    }
  };
  draw(kCommon);
  draw(drawn.ranges);
  auto scene = std::make_shared<PlantScene>();
  build_shape(course, random, *scene);
  course.scene = scene;
  course.start_m.z = course.height(course.start_m.x, course.start_m.y) + kBodyHeight_m;
  return course;
}

Course mirrored(const Course& course) {
  Course other = course;
  const auto scene = std::make_shared<PlantScene>();
  if (add_mirrored(*course.scene, *scene) != Status::ok)
    throw std::runtime_error("hil course: it cannot be mirrored");
  other.scene = scene;
  other.start_m.y = -course.start_m.y;
  other.start_yaw_rad = -course.start_yaw_rad;
  other.goal_y_m = -course.goal_y_m;
  return other;
}

PlantConfig plant_config(const Course& course) {
  PlantConfig config;
  config.start_m = course.start_m;
  config.start_q_world_body = from_yaw_pitch_roll(course.start_yaw_rad, 0.0, 0.0);
  config.vehicle.friction = course.parameter("friction");
  config.vehicle.body_friction = std::min(config.vehicle.body_friction, config.vehicle.friction);
  config.vehicle.load_mass_kg = course.parameter("load_kg");
  config.vehicle.load_centre_m.z = course.parameter("load_height_m");
  return config;
}

std::uint64_t digest_of_course(const Course& course) {
  std::uint64_t chain = 0;
  std::uint64_t count = 0;
  const auto take = [&](double value) {
    chain = rt::chain_digest(chain, count++, rt::digest_bytes(&value, sizeof(value)));
  };
  for (const CourseParameter& p : course.parameters) take(p.value);
  for (const double v : {course.start_m.x, course.start_m.y, course.start_m.z, course.start_yaw_rad,
                         course.goal_x_m, course.goal_y_m, course.half_width_m, course.obstacle_m})
    take(v);
  for (const PlantScene::Solid& solid : course.scene->solids()) {
    const rt::convex::Convex& b = solid.shape;
    for (const double v :
         {b.p_world_m.x, b.p_world_m.y, b.p_world_m.z, b.half_m.x, b.half_m.y, b.half_m.z, b.radius_m[0]})
      take(v);
    for (const double v : b.R_world_body.m) take(v);
  }
  return chain;
}

}  // namespace sortie::hil
