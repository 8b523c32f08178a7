// SPDX-License-Identifier: BSD-3-Clause
// Drawn courses: the same on every board, within their ranges, and as high as rays find the plant's solids.
#include "hil/plant/course_families.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "hil/plant/course.hpp"
#include "hil/random.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

constexpr CourseUse kUses[] = {CourseUse::tuning, CourseUse::judging};

TerrainFamily family_at(int index) { return static_cast<TerrainFamily>(index); }

/// The ranges as the task has them, written down a second time.
const std::map<std::string, std::pair<double, double>>& asked_ranges(TerrainFamily family) {
  constexpr double kDeg = 3.14159265358979323846 / 180.0;
  using Ranges = std::map<std::string, std::pair<double, double>>;
  static const std::map<TerrainFamily, Ranges> all = {
      {TerrainFamily::step_up, {{"height_m", {0.05, 0.4}}}},
      {TerrainFamily::step_down, {{"height_m", {0.05, 0.6}}}},
      {TerrainFamily::uplift, {{"height_m", {0.05, 0.4}}, {"length_m", {0.2, 0.5}}}},
      {TerrainFamily::single_step, {{"height_m", {0.05, 0.3}}, {"length_m", {0.3, 0.8}}}},
      {TerrainFamily::posts,
       {{"height_m", {0.2, 0.5}}, {"spread_m", {0, 0.15}}, {"gap_m", {0.05, 0.2}}, {"side_m", {0.1, 0.2}}}},
      {TerrainFamily::waves, {{"height_m", {0.1, 0.4}}, {"period_m", {0.25, 1}}}},
      {TerrainFamily::rails,
       {{"height_m", {0.05, 0.3}}, {"angle_rad", {10 * kDeg, 45 * kDeg}}, {"width_m", {0.05, 0.15}}}},
      {TerrainFamily::stairs_up,
       {{"angle_rad", {20 * kDeg, 45 * kDeg}}, {"tread_m", {0.2, 0.3}}, {"steps", {3, 6}}}},
      {TerrainFamily::stairs_down,
       {{"angle_rad", {20 * kDeg, 45 * kDeg}}, {"tread_m", {0.2, 0.3}}, {"steps", {3, 6}}}},
      {TerrainFamily::pallets, {{"count", {1, 3}}, {"gap_m", {0, 0.3}}}},
      {TerrainFamily::ramp, {{"slope_rad", {5 * kDeg, 40 * kDeg}}, {"length_m", {0.8, 2}}}},
      {TerrainFamily::rubble, {{"blocks", {15, 60}}, {"length_m", {1, 2}}}},
      {TerrainFamily::gap, {{"length_m", {0.1, 0.45}}, {"depth_m", {0.2, 0.6}}}}};
  return all.at(family);
}

/// Height by a ray that falls from 3 m onto the world's copy of the solids.
double height_by_ray(const World& world, double x, double y) {
  const Hit hit = world.cast({x, y, 3.0}, {0, 0, -1}, 10.0);
  return 3.0 - hit.range_m;
}

}  // namespace

TEST_CASE("courses: equal arguments give equal courses, other seeds, uses and families others", "[course]") {
  std::set<std::uint64_t> seen;
  std::size_t drawn = 0;
  std::uint64_t chain = 0;
  for (const CourseUse use : kUses) {
    for (int f = 0; f < kTerrainFamilies; ++f) {
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const double difficulty = 0.05 * static_cast<double>(seed);
        const std::uint64_t one = digest_of_course(draw_course(use, family_at(f), seed, difficulty));
        CHECK(one == digest_of_course(draw_course(use, family_at(f), seed, difficulty)));
        seen.insert(one);
        ++drawn;
        chain = chain * 0x9e3779b97f4a7c15u + one;
      }
    }
  }
  CHECK(seen.size() == drawn);
  CHECK(chain == 0x899f7f3b4bfe6e1b);  // of every board and compiler
}

TEST_CASE("courses: 1,000 seeds of each family and use lie within the ranges", "[course]") {
  for (const CourseUse use : kUses) {
    for (int f = 0; f < kTerrainFamilies; ++f) {
      const TerrainFamily family = family_at(f);
      auto ranges = asked_ranges(family);
      ranges["friction"] = {0.3, 1.0};
      ranges["load_kg"] = {0.0, 8.0};
      ranges["load_height_m"] = {0.15, 0.35};
      std::map<std::string, std::pair<double, double>> met;
      for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
        const Course course = draw_course(use, family, seed, static_cast<double>(seed % 101) / 100.0);
        REQUIRE(course.parameters.size() == ranges.size());
        for (const CourseParameter& p : course.parameters) {
          REQUIRE(ranges.count(p.name) == 1);
          auto& span = met.try_emplace(p.name, p.value, p.value).first->second;
          span = {std::min(span.first, p.value), std::max(span.second, p.value)};
        }
        REQUIRE(course.goal_x_m > course.obstacle_m);
        REQUIRE(course.obstacle_m > 0.7);
      }
      for (const auto& [name, asked] : ranges) {
        INFO(name_of(family) << " " << name << " use " << static_cast<int>(use));
        const double tenth = 0.1 * (asked.second - asked.first);
        CHECK(met[name].first >= asked.first - 1e-12);
        CHECK(met[name].second <= asked.second + 1e-12);
        CHECK(met[name].first <= asked.first + tenth);  // and all of the range is drawn
        CHECK(met[name].second >= asked.second - tenth);
      }
    }
  }
}

TEST_CASE("courses: heights are those that rays find", "[course]") {
  std::uint64_t rays = 0;
  for (const CourseUse use : kUses) {
    for (int f = 0; f < kTerrainFamilies; ++f) {
      for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        Course course = draw_course(use, family_at(f), seed, static_cast<double>(seed) / 12.0);
        if (seed % 2 == 0) course = mirrored(course);
        const auto world = std::make_unique<World>();
        REQUIRE(add_to_world(*course.scene, *world) == Status::ok);
        INFO(name_of(course.family) << " seed " << seed);
        REQUIRE(world->finalize() == Status::ok);
        Random random(seed, 0x68656967);
        for (int k = 0; k < 2000; ++k) {
          const double x = random.uniform(-1.0, course.goal_x_m + 1.0);
          const double y = random.uniform(-course.half_width_m, course.half_width_m);
          const double ray = height_by_ray(*world, x, y);
          if (std::fabs(course.height(x, y) - ray) > 1e-9) {
            INFO("at " << x << ", " << y);
            REQUIRE(course.height(x, y) == Approx(ray).margin(1e-9));
          }
          ++rays;
        }
      }
    }
  }
  CHECK(rays == 2u * 13u * 12u * 2000u);
}

TEST_CASE("courses: a mirrored course is as high as the course on the other side", "[course]") {
  for (int f = 0; f < kTerrainFamilies; ++f) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Course course = draw_course(CourseUse::judging, family_at(f), seed, 0.5);
      const Course image = mirrored(course);
      CHECK(image.start_m.y == -course.start_m.y);
      CHECK(image.start_yaw_rad == -course.start_yaw_rad);
      Random random(seed, 0x6d697272);
      int apart = 0;
      for (int k = 0; k < 500; ++k) {
        const double x = random.uniform(-1.0, course.goal_x_m + 1.0);
        const double y = random.uniform(-1.0, 1.0);
        if (std::fabs(course.height(x, y) - image.height(x, -y)) > 1e-9) ++apart;
      }
      INFO(name_of(course.family) << " seed " << seed);
      CHECK(apart == 0);
    }
  }
}

TEST_CASE("courses: tuning's shapes have the heights of their closed forms", "[course]") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed, 0x666f726d);
    const auto at = [&](TerrainFamily family) {
      return draw_course(CourseUse::tuning, family, seed, static_cast<double>(seed) / 50.0);
    };
    const Course up = at(TerrainFamily::step_up);
    const Course down = at(TerrainFamily::step_down);
    const Course gap = at(TerrainFamily::gap);
    const Course box = at(TerrainFamily::uplift);
    const Course stairs = at(TerrainFamily::stairs_up);
    const Course ramp = at(TerrainFamily::ramp);
    const Course waves = at(TerrainFamily::waves);
    const Course flight = at(TerrainFamily::stairs_down);
    for (int k = 0; k < 200; ++k) {
      const double x = random.uniform(-0.9, 4.0);
      const double y = random.uniform(-1.0, 1.0);
      const double past = x - 1.0;
      CHECK(up.height(x, y) == Approx(past > 0 ? up.parameter("height_m") : 0.0).margin(1e-12));
      CHECK(down.height(x, y) == Approx(past > 0 ? 0.0 : down.parameter("height_m")).margin(1e-12));
      const bool in_gap = past > 0 && past < gap.parameter("length_m");
      if (x < gap.goal_x_m)
        CHECK(gap.height(x, y) == Approx(in_gap ? 0.0 : gap.parameter("depth_m")).margin(1e-12));
      const bool on_box = past > 0 && past < box.parameter("length_m");
      CHECK(box.height(x, y) == Approx(on_box ? box.parameter("height_m") : 0.0).margin(1e-12));
      const auto stair = [](const Course& c, double along) {
        const double count = std::round(c.parameter("steps"));
        const double level = std::min(count, std::floor(along / c.parameter("tread_m")) + 1.0);
        return std::max(0.0, level) * c.parameter("tread_m") * std::tan(c.parameter("angle_rad"));
      };
      if (x < stairs.goal_x_m) CHECK(stairs.height(x, y) == Approx(stair(stairs, past)).margin(1e-9));
      const double last = (std::round(flight.parameter("steps")) - 1.0) * flight.parameter("tread_m");
      CHECK(flight.height(x, y) == Approx(stair(flight, last - past)).margin(1e-9));
      const double rise = std::min(std::max(0.0, past) * std::tan(ramp.parameter("slope_rad")),
                                   ramp.parameter("length_m") * std::sin(ramp.parameter("slope_rad")));
      if (x < ramp.goal_x_m) CHECK(ramp.height(x, y) == Approx(rise).margin(1e-9));
      // A cosine, but for its facets: at most what a chord of an eighth of a period leaves out, and at a
      // steep crest a facet's end of less than its 2 cm.
      const double phase = 2.0 * 3.14159265358979 * past / waves.parameter("period_m");
      const double end = std::floor(2.0 / waves.parameter("period_m")) * waves.parameter("period_m");
      const double high = waves.parameter("height_m");
      const double wave = past > 0 && past < end ? 0.5 * high * (1.0 - std::cos(phase)) : 0.0;
      CHECK(std::fabs(waves.height(x, y) - wave) < 0.5 * high * (1.0 - std::cos(3.14159 / 8.0)) + 0.02);
    }
  }
}

TEST_CASE("courses: a start stands on level ground, and a refusal says why", "[course]") {
  for (const CourseUse use : kUses) {
    for (int f = 0; f < kTerrainFamilies; ++f) {
      for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        const Course course = draw_course(use, family_at(f), seed, 0.5);
        const double here = course.height(course.start_m.x, course.start_m.y);
        CHECK(course.start_m.z == Approx(here + 0.07192));
        for (double x = -0.6; x <= 0.6; x += 0.1)
          for (double y = -0.4; y <= 0.4; y += 0.1) CHECK(course.height(x, y) == here);
        CHECK_THROWS(course.parameter("colour"));
      }
    }
  }
  CHECK_THROWS(draw_course(CourseUse::tuning, TerrainFamily::gap, 1, 1.01));
  CHECK_THROWS(draw_course(CourseUse::tuning, TerrainFamily::gap, 1, std::nan("")));
  CHECK_THROWS(draw_course(CourseUse::tuning, static_cast<TerrainFamily>(13), 1, 0.5));
}

TEST_CASE("courses: a load moves mass, centre of mass and inertia as a point does", "[course]") {
  const VehicleModel bare{VehicleConfig{}};
  VehicleConfig loaded;
  loaded.load_mass_kg = 6.0;
  loaded.load_centre_m = {-0.1, 0.0, 0.3};
  const VehicleModel model{loaded};
  const double angles[kFlippers] = {0.3, 0.3, -0.2, 0.5};
  MassState before, after;
  bare.mass_at(angles, before);
  model.mass_at(angles, after);
  CHECK(after.mass_kg == Approx(before.mass_kg + 6.0));
  const Vec3 com = (1.0 / after.mass_kg) * (before.mass_kg * before.com_m + 6.0 * loaded.load_centre_m);
  CHECK(norm(after.com_m - com) < 1e-12);
  // Kinetic energy of turning about y, from two models that differ by a point: m r^2 w^2 / 2.
  Generalised turn;
  turn.angular = {0.0, 2.0, 0.0};
  const double more =
      0.5 * dot(turn, multiply(after.matrix, turn)) - 0.5 * dot(turn, multiply(before.matrix, turn));
  CHECK(more == Approx(0.5 * 6.0 * (0.1 * 0.1 + 0.3 * 0.3) * 4.0));
  loaded.load_mass_kg = -1.0;
  CHECK_THROWS(VehicleModel{loaded});
}
