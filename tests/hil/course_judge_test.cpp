// SPDX-License-Identifier: BSD-3-Clause
// The judge of drives: what every driver passes, what none does, who tips, and each rule by itself.
#include "hil/plant/course_judge.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "hil/plant/course_drivers.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

/// A course by hand: level ground at z = 0 and what is built on it, 3 m long.
Course hand_made(const std::function<void(PlantScene&)>& build, double start_z_m = 0.0) {
  Course course;
  for (const CourseParameter& p : {CourseParameter{"friction", 0.8}, CourseParameter{"load_kg", 0.0},
                                   CourseParameter{"load_height_m", 0.2}})
    REQUIRE(course.parameters.push_back(p));
  const auto scene = std::make_shared<PlantScene>();
  REQUIRE(scene->add_half_space({0, 0, 1}, {0, 0, 0}) == Status::ok);
  build(*scene);
  course.scene = scene;
  course.start_m.z = start_z_m + 0.07192;
  course.goal_x_m = 3.0;
  course.obstacle_m = 1.0;
  course.half_width_m = 1.0;
  return course;
}

void box(PlantScene& scene, const Vec3& low, const Vec3& high) {
  REQUIRE(scene.add_box(0.5 * (low + high), {}, 0.5 * (high - low)) == Status::ok);
}

Course flat_course() {
  return hand_made([](PlantScene&) {});
}

/// A driver that is one function.
struct FunctionDriver : FlipperDriver {
  explicit FunctionDriver(std::function<DriverOrder(const DriverView&)> order) : order_(std::move(order)) {}
  void begin(const Course&) override {}
  DriverOrder drive(const DriverView& view) override { return order_(view); }
  std::function<DriverOrder(const DriverView&)> order_;
};

DriverOrder belts(double left_m_s, double right_m_s, double angle_rad = 0.0) {
  DriverOrder order;
  order.command.left_m_s = left_m_s;
  order.command.right_m_s = right_m_s;
  for (double& angle : order.command.flipper_rad) angle = angle_rad;
  return order;
}

CourseResult drive_script(const Course& course, const FlipperScript& script, const JudgeConfig& config = {}) {
  ScriptDriver driver(script);
  return judge_course(course, driver, config);
}

}  // namespace

TEST_CASE("judge: every posture, script and the operator pass level ground, and touch nothing", "[course]") {
  const Course course = flat_course();
  std::vector<FlipperScript> scripts(script_grid().begin(), script_grid().end());
  for (const NamedPosture& posture : fixed_postures()) scripts.push_back(fixed_posture(posture.angles));
  for (const FlipperScript& script : scripts) {
    CAPTURE(script.before.front_rad, script.before.rear_rad, script.after.front_rad, script.after.rear_rad);
    const CourseResult r = drive_script(course, script);
    CHECK(r.end == CourseEnd::reached);
    CHECK(r.belly_contacts == 0);
    CHECK(r.not_converged == 0);
    CHECK(r.time_s == Approx(2.75 / 0.25 + 0.25).margin(1.0));
  }
  OperatorDriver driver;
  const CourseResult r = judge_course(course, driver);
  CHECK(r.end == CourseEnd::reached);
  CHECK(r.peak_pitch_rate_rad_s < 0.2);
}

TEST_CASE("judge: nothing passes a wall of 1 m", "[course]") {
  const Course course = hand_made([](PlantScene& scene) { box(scene, {1, -3, 0}, {1.5, 3, 1}); });
  JudgeConfig config;
  config.stuck_s = 3.0;
  CHECK_FALSE(grid_passes(course, config));
  for (const NamedPosture& posture : fixed_postures())
    CHECK(drive_script(course, fixed_posture(posture.angles), config).end != CourseEnd::reached);
  OperatorDriver driver;
  const CourseResult r = judge_course(course, driver, config);
  CHECK(r.end != CourseEnd::reached);
  CHECK(r.touched);
}

TEST_CASE("judge: who creeps off 0.6 m with folded flippers has tipped over, who stretches them has not",
          "[course]") {
  const Course course = hand_made([](PlantScene& scene) { box(scene, {-3, -3, 0}, {1, 3, 0.6}); }, 0.6);
  for (const double speed : {0.05, 0.15, 0.25}) {
    CAPTURE(speed);
    JudgeConfig config;
    config.time_out_s = 60.0;
    FlipperScript folded = fixed_posture({2.4, 2.4});
    folded.speed_m_s = speed;
    const CourseResult r = drive_script(course, folded, config);
    CHECK(r.end == CourseEnd::tipped);
    CHECK(std::max(r.peak_pitch_rad, r.peak_roll_rad) >= 1.39);
    FlipperScript stretched = fixed_posture({0.0, 0.0});
    stretched.speed_m_s = speed;
    CHECK(drive_script(course, stretched, config).end == CourseEnd::reached);
  }
}

TEST_CASE("judge: each rule ends a drive by itself", "[course]") {
  const Course course = flat_course();
  JudgeConfig config;
  config.time_out_s = 3.0;
  config.time_out_s_m = 1.0;
  const auto end_of_order = [&](const std::function<DriverOrder(const DriverView&)>& order) {
    FunctionDriver driver(order);
    return judge_course(course, driver, config);
  };
  CHECK(end_of_order([](const DriverView&) { return belts(0.4, 0.4); }).end == CourseEnd::timed_out);
  config.time_out_s = 20.0;
  CHECK(end_of_order([](const DriverView&) { return belts(0.4, 0.4); }).end == CourseEnd::reached);
  CHECK(end_of_order([](const DriverView&) { return belts(-0.2, -0.2); }).end == CourseEnd::left);
  CHECK(end_of_order([](const DriverView&) { return belts(-0.1, 0.1); }).end == CourseEnd::turned);
  const CourseResult still = end_of_order([](const DriverView&) { return belts(0.0, 0.0); });
  CHECK(still.end == CourseEnd::timed_out);
  CHECK(still.time_s == Approx(23.0).margin(0.01));
  config.stuck_s = 2.0;
  CHECK(end_of_order([](const DriverView&) { return belts(0.0, 0.0); }).time_s < 2.1);
  CHECK_THROWS(end_of_order([](const DriverView&) { return belts(std::nan(""), 0.0); }));
}

TEST_CASE("judge: a refusal counts as in time as long as nothing beyond the edge was touched", "[course]") {
  const Course course = hand_made([](PlantScene& scene) { box(scene, {1, -3, 0}, {1.5, 3, 0.3}); });
  const auto refuse_at = [&](double x_m) {
    FunctionDriver driver([x_m](const DriverView& view) {
      DriverOrder order = belts(0.2, 0.2, 0.5);
      order.refuse = view.p_world_m.x >= x_m;
      return order;
    });
    return judge_course(course, driver);
  };
  const CourseResult early = refuse_at(0.2);
  CHECK(early.end == CourseEnd::refused);
  CHECK(early.refused_before_contact());
  const CourseResult late = refuse_at(0.7);
  CHECK(late.end == CourseEnd::refused);
  CHECK_FALSE(late.refused_before_contact());
}

TEST_CASE("judge: who refuses when it is too late has tipped over", "[course]") {
  const Course course = hand_made([](PlantScene& scene) { box(scene, {-3, -3, 0}, {1, 3, 0.6}); }, 0.6);
  const auto refuse_at = [&](double nose_down) {
    FunctionDriver driver([nose_down](const DriverView& view) {
      DriverOrder order = belts(0.1, 0.1, 2.4);
      order.refuse = rotate(view.q_world_body, {1, 0, 0}).z < -nose_down;
      return order;
    });
    JudgeConfig config;
    config.time_out_s = 60.0;
    return judge_course(course, driver, config).end;
  };
  CHECK(refuse_at(-0.1) == CourseEnd::refused);  // before the first step of the drive
  CHECK(refuse_at(0.2) == CourseEnd::tipped);    // nose over the edge: nothing stops that
}

TEST_CASE("judge: a ridge between the tracks is a belly contact", "[course]") {
  const Course course = hand_made([](PlantScene& scene) {
    box(scene, {1.0, -0.06, 0}, {1.2, 0.06, 0.16});
    box(scene, {1.9, -0.06, 0}, {2.1, 0.06, 0.16});
  });
  const CourseResult r = drive_script(course, fixed_posture({0.7, 0.0}));
  CHECK(r.belly_contacts >= 1);
  CHECK(r.belly_s > 0.0);
  CHECK(r.touched);
}

TEST_CASE("judge: peaks are those of a twin that looks at every step", "[course]") {
  double highest = 0.0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    const Course course =
        draw_course(CourseUse::judging, static_cast<TerrainFamily>(2 * seed), seed, 0.2);  // six families
    struct Twin : ScriptDriver {
      using ScriptDriver::ScriptDriver;
      DriverOrder drive(const DriverView& view) override {
        rates.push_back(view.w_body_rad_s.y);
        climbs.push_back(view.v_world_m_s.z);
        return ScriptDriver::drive(view);
      }
      std::vector<double> rates, climbs;
    } twin(fixed_posture({0.7, 0.0}));
    JudgeConfig config;
    config.steps_per_order = 1;
    config.stuck_s = 3.0;
    const CourseResult r = judge_course(course, twin, config);
    // The first view is before the settling; the drive's own follow, one a step.
    double rate = 0.0, vertical = 0.0;
    for (std::size_t k = 1; k + 5 < twin.rates.size(); k += 5) {
      double sum = 0.0;
      for (std::size_t i = 1; i <= 5; ++i) sum += twin.rates[k + i];
      rate = std::max(rate, std::fabs(sum / 5.0));
      vertical = std::max(vertical, std::fabs(twin.climbs[k + 5] - twin.climbs[k]) / 0.01);
    }
    highest = std::max(highest, rate);
    CHECK(r.peak_pitch_rate_rad_s >= rate - 1e-9);
    CHECK(r.peak_vertical_m_s2 >= vertical - 1e-6);
    // The judge sees one window more at most, that of the last steps.
    if (r.end == CourseEnd::reached) {
      CHECK(r.peak_pitch_rate_rad_s == Approx(rate).margin(0.01));
      CHECK(r.peak_vertical_m_s2 == Approx(vertical).margin(0.1));
    }
  }
  CHECK(highest > 0.5);
}

TEST_CASE("judge: a mirrored course gives the mirrored drive of a symmetric script, and again the same bits",
          "[course]") {
  for (int f = 0; f < kTerrainFamilies; ++f) {
    const auto seed = static_cast<std::uint64_t>(101 + f);
    const Course course = draw_course(CourseUse::judging, static_cast<TerrainFamily>(f), seed, 0.2);
    INFO(name_of(course.family) << " seed " << seed);
    JudgeConfig config;
    config.stuck_s = 3.0;
    const FlipperScript script = fixed_posture({0.4, 0.0});
    const CourseResult one = drive_script(course, script, config);
    const CourseResult image = drive_script(mirrored(course), script, config);
    CHECK(one.end == image.end);
    // Contacts are found and solved in an order that is not the mirror's: on 182 other courses paths parted
    // by up to 0.9 mm, and arrived up to 28 ms apart, less than an order takes.
    CHECK(norm(one.end_m - Vec3{image.end_m.x, -image.end_m.y, image.end_m.z}) < 2e-3);
    CHECK(std::fabs(one.time_s - image.time_s) < 0.05);
    const CourseResult again = drive_script(course, script, config);
    CHECK(norm(one.end_m - again.end_m) == 0.0);
    CHECK(one.peak_vertical_m_s2 == again.peak_vertical_m_s2);
    CHECK(one.time_s == again.time_s);
  }
}
