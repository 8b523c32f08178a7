// SPDX-License-Identifier: BSD-3-Clause
// Postures against closed forms, a brute-force search, their mirror images, and inputs that say nothing.
#include "planner/posture.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "hil/random.hpp"
#include "tests/planner/posture_courses.hpp"
#include "tests/planner/posture_ground_twins.hpp"

namespace sortie::planner {
namespace {

std::unique_ptr<PostureSolver> posture_solver() {
  auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, PostureConfig{});
  REQUIRE(solver->usable() == Status::ok);
  return solver;
}

Posture posture_on(const FormulaGround& ground, const StandPose& pose, const FlipperSet& flippers) {
  const auto solver = posture_solver();
  REQUIRE(solver->look(ground.view(), pose) == Status::ok);
  Posture posture;
  REQUIRE(solver->rest(flippers, posture) == Status::ok);
  return posture;
}

constexpr FlipperSet kFolded{{2.0, 2.0, 2.0, 2.0}};
constexpr double kRun_m = 0.07192;  // of the origin above the tracks' lower run
constexpr double kDegree = 0.0174532925199433;

}  // namespace

TEST_CASE("a posture on the flat is level", "[planner][posture]") {
  const Posture p = posture_on({[](double, double) { return 3.0; }}, {1.0, -2.0, 0.3}, kFolded);
  CHECK(p.rest == Rest::stands);
  CHECK(std::fabs(p.pitch_rad) < 1e-6);
  CHECK(std::fabs(p.roll_rad) < 1e-6);
  CHECK(p.height_m == Approx(3.0 + kRun_m).margin(1e-5));
  CHECK(p.clearance_m == Approx(kRun_m + 0.0485).margin(1e-5));
  // The rear end of the run is nearer than a side: 0.25 m behind, the centre of mass 0.057 m and what
  // folded flippers add.
  const rt::Vector3 com = centre_of_mass(PostureVehicle{}, kFolded);
  CHECK(p.margin_m == Approx(0.25 + com.x).margin(2e-3));
  const double up = com.z + kRun_m;
  CHECK(p.tip_energy_j == Approx(28.26 * 9.81 * (std::hypot(p.margin_m, up) - up)).margin(0.5));
}

TEST_CASE("a posture on a plane has its slope, whatever the heading", "[planner][posture]") {
  for (int k = 0; k < 24; ++k) {
    const double yaw = 0.27 * k;
    const double slope = 0.02 * k;
    const FormulaGround ground{[slope](double x, double) { return slope * x; }};
    const Posture p = posture_on(ground, {0.3, 0.1, yaw}, kFolded);
    INFO("yaw " << yaw << " slope " << slope);
    // Up of the plane in the heading's axes says pitch and roll.
    const double ahead = -slope * std::cos(yaw), left = slope * std::sin(yaw);
    CHECK(p.pitch_rad == Approx(std::atan(ahead)).margin(2e-3));
    CHECK(p.roll_rad == Approx(std::atan(-left * std::cos(p.pitch_rad))).margin(2e-3));
    CHECK(p.height_m == Approx(slope * 0.3 + kRun_m * std::sqrt(1.0 + slope * slope)).margin(2e-3));
    CHECK(p.rest == Rest::stands);
  }
}

TEST_CASE("a step under the front flippers lifts the nose by its height", "[planner][posture]") {
  // Level flippers reach 0.58 m ahead; the edge at 0.45 m carries them, the rear flippers' tips or wheels the
  // rest.
  for (const double high : {0.05, 0.10, 0.15}) {
    const FormulaGround ground{[high](double x, double) { return x > 0.45 ? high : 0.0; }};
    const Posture p = posture_on(ground, {0.0, 0.0, 0.0}, {{0.0, 0.0, 1.5, 1.5}});
    INFO("step " << high);
    // The rear wheel stays down: h(d) of its disc; the flipper's lower side passes through the edge.
    const double d = -p.pitch_rad;
    const double origin = 0.09047 + 0.25 * std::sin(d) - 0.01855 * std::cos(d);
    CHECK(p.height_m == Approx(origin).margin(2e-3));
    const double taper = std::asin((0.089 - 0.029) / 0.33);
    const double angle = d + taper;  // of the flipper's lower run
    const double pivot_x = 0.25 * std::cos(d) - 0.0195 * std::sin(d);
    const double pivot_z = origin + 0.25 * std::sin(d) + 0.0195 * std::cos(d);
    const double run = pivot_z - 0.089 / std::cos(angle) + (0.45 - pivot_x) * std::tan(angle);
    CHECK(run == Approx(high).margin(8e-3));
    CHECK(std::fabs(p.roll_rad) < 1e-6);
    CHECK(p.rest == Rest::stands);
  }
}

TEST_CASE("a gap as long as the tracks is bridged by flippers alone", "[planner][posture]") {
  const FormulaGround ground{[](double x, double) { return std::fabs(x) < 0.45 ? -1.0 : 0.0; }};
  const Posture stretched = posture_on(ground, {0.0, 0.0, 0.0}, {{-0.2, -0.2, -0.2, -0.2}});
  CHECK(stretched.rest == Rest::stands);
  CHECK(std::fabs(stretched.pitch_rad) < 0.02);
  CHECK((stretched.parts & 7u) == 0u);  // neither belly nor tracks
  const Posture folded = posture_on(ground, {0.0, 0.0, 0.0}, kFolded);
  CHECK(folded.height_m < -0.5);  // at the bottom of it
}

TEST_CASE("a ridge under the belly carries it", "[planner][posture]") {
  const FormulaGround ground{
      [](double x, double y) { return std::fabs(y) < 0.075 && std::fabs(x) < 1 ? 0.3 : 0.0; }};
  const Posture p = posture_on(ground, {0.0, 0.0, 0.0}, kFolded);
  CHECK((p.parts & 1u) == 1u);
  CHECK(p.clearance_m == 0.0);
  CHECK(p.margin_m < 0.09);
}

TEST_CASE("at a cliff the nose goes over as soon as the centre of mass does", "[planner][posture]") {
  for (int k = -6; k <= 6; ++k) {
    const double edge = 0.05 * k;
    const FormulaGround ground{[edge](double x, double) { return x > edge ? -2.0 : 0.0; }};
    const Posture p = posture_on(ground, {0.0, 0.0, 0.0}, kFolded);
    const double com = centre_of_mass(PostureVehicle{}, kFolded).x;
    INFO("edge " << edge << " centre of mass " << com);
    if (edge > com + 0.03) {
      CHECK(p.rest == Rest::stands);
      CHECK(p.margin_m == Approx(std::min(edge - com, 0.25 + com)).margin(0.03));
    }
    if (edge < com - 0.03) CHECK((p.rest == Rest::tips || p.pitch_rad > 0.5));
  }
}

TEST_CASE("a cell stands for its middle, and for its upper side where it holds an edge",
          "[planner][posture]") {
  for (const double wide : {0.02, 0.06, 0.12, 0.3}) {
    static double span;
    span = wide;
    const HeightView view{nullptr,
                          [](const void*, std::int64_t, std::int64_t) {
                            return HeightCell{0.0, span, HeightState::known};
                          },
                          0.05};
    const auto solver = posture_solver();
    REQUIRE(solver->look(view, {}) == Status::ok);
    Posture p;
    REQUIRE(solver->rest(kFolded, p) == Status::ok);
    CHECK(p.height_m == Approx(kRun_m + (wide > 0.08 ? wide : 0.5 * wide)).margin(1e-5));
  }
}

TEST_CASE("postures are those of a brute-force search", "[heavy]") {
  // Waves: no edges, so that cells lose nothing, and the twin needs none.
  const PostureVehicle vehicle;
  int same = 0, other_rest = 0, count = 0;
  double worst_height = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    hil::Random random(seed, 0x77617665);
    double wave[4][4];
    for (auto& w : wave) {
      w[0] = random.uniform(-9.0, 9.0);
      w[1] = random.uniform(-9.0, 9.0);
      w[2] = random.uniform(0.0, 6.28);
      w[3] = random.uniform(0.0, 0.03);
    }
    const FormulaGround ground{[&](double x, double y) {
      double h = 0.0;
      for (const auto& w : wave) h += w[3] * std::sin(w[0] * x + w[1] * y + w[2]);
      return h;
    }};
    FlipperSet flippers;
    for (double& angle : flippers.angle_rad) angle = random.uniform(-0.4, 1.2);
    const StandPose pose{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-3, 3)};
    const Posture p = posture_on(ground, pose, flippers);
    INFO("seed " << seed);
    CHECK(p.rest == Rest::stands);
    const std::vector<rt::Vector3> points = underside_points(vehicle, flippers);
    const rt::Vector3 com = centre_of_mass(vehicle, flippers);
    double pitch = 0.0, roll = 0.0, best = 1e9;
    for (int i = -6; i <= 6; ++i) {
      for (int j = -6; j <= 6; ++j) {
        const double height = let_down(ground, points, com, pose, 0.08 * i, 0.08 * j).com_m;
        if (height >= best) continue;
        best = height;
        pitch = 0.08 * i;
        roll = 0.08 * j;
      }
    }
    descend(ground, points, com, pose, 0.04, pitch, roll);
    const auto apart = [&](double a, double b) {
      return std::max(std::fabs(a - p.pitch_rad), std::fabs(b - p.roll_rad));
    };
    ++count;
    if (apart(pitch, roll) < kDegree) {
      ++same;
    } else {
      // Another rest: the search that starts there stays.
      double from_pitch = p.pitch_rad, from_roll = p.roll_rad;
      descend(ground, points, com, pose, 0.01, from_pitch, from_roll);
      CHECK(apart(from_pitch, from_roll) < 2.0 * kDegree);
      ++other_rest;
    }
    const double height = let_down(ground, points, com, pose, p.pitch_rad, p.roll_rad).origin_m;
    worst_height = std::max(worst_height, std::fabs(height - p.height_m));
  }
  INFO("same " << same << ", another rest " << other_rest << " of " << count << ", height " << worst_height);
  CHECK(same >= 0.9 * count);
  CHECK(worst_height < 0.005);
}

TEST_CASE("a mirrored world gives the mirrored posture to the last bit", "[planner][posture]") {
  struct Mirrored {
    const BoxCourse* course;
    static HeightCell cell(const void* m, std::int64_t i, std::int64_t j) {
      return BoxCourse::cell(static_cast<const Mirrored*>(m)->course, i, -1 - j);
    }
  };
  const auto solver = posture_solver();
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    hil::Random random(seed, 0x6d697272);
    const BoxCourse course = random_course(kCourseFamilies[seed % 5], random);
    FlipperSet flippers;
    for (double& angle : flippers.angle_rad) angle = random.uniform(-0.6, 1.2);
    const double* a = flippers.angle_rad;
    const FlipperSet exchanged{{a[1], a[0], a[3], a[2]}};
    const StandPose pose{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-3, 3)};
    Posture p, q;
    REQUIRE(solver->look(course.view(), pose) == Status::ok);
    REQUIRE(solver->rest(flippers, p) == Status::ok);
    const Mirrored mirrored{&course};
    REQUIRE(solver->look({&mirrored, &Mirrored::cell, course.cell_m}, {pose.x_m, -pose.y_m, -pose.yaw_rad}) ==
            Status::ok);
    REQUIRE(solver->rest(exchanged, q) == Status::ok);
    INFO("seed " << seed);
    CHECK(p.pitch_rad == q.pitch_rad);
    CHECK(p.roll_rad == -q.roll_rad);
    CHECK(p.height_m == q.height_m);
    CHECK(p.margin_m == q.margin_m);
    CHECK(p.tip_energy_j == q.tip_energy_j);
    CHECK(p.clearance_m == q.clearance_m);
    CHECK(p.contacts == q.contacts);
    CHECK(p.rest == q.rest);
    for (unsigned part = 0; part < 7; ++part) {  // the body, then left and right in turn
      const unsigned other = part == 0 ? 0 : (part % 2 == 1 ? part + 1 : part - 1);
      CHECK((p.parts >> part & 1) == (q.parts >> other & 1));
    }
  }
}

TEST_CASE("samples at three quarters of a cell lie within the window at every heading") {
  PostureConfig config;
  config.ground.spacing_m = 0.0375;
  const auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, config);
  REQUIRE(solver->usable() == Status::ok);
  const FormulaGround slope{[](double x, double y) { return 0.1 * x - 0.2 * y; }};
  hil::Random random(1, 0x77696e64);
  for (int k = 0; k < 720; ++k) {
    const StandPose pose{random.uniform(-3, 3), random.uniform(-3, 3), k * kDegree / 2};
    REQUIRE(solver->look(slope.view(), pose) == Status::ok);
    for (const int column : {-32, 0, 32}) {
      for (const int row : {-20, 0, 20}) {
        const double ahead = 0.0375 * column, aside = 0.0375 * row;
        const double x = pose.x_m + std::cos(pose.yaw_rad) * ahead - std::sin(pose.yaw_rad) * aside;
        const double y = pose.y_m + std::sin(pose.yaw_rad) * ahead + std::cos(pose.yaw_rad) * aside;
        const double mirrored = static_cast<double>(solver->ground().height(column, -row));
        const double here = static_cast<double>(solver->ground().height(column, row));
        const double is = 0.1 * x - 0.2 * y;
        CHECK(std::min(std::fabs(here - is), std::fabs(mirrored - is)) < 1e-4);
      }
    }
  }
}

TEST_CASE("a belly over nothing that is known has no clearance") {
  const HeightView rails{
      nullptr,
      [](const void*, std::int64_t, std::int64_t j) {
        const bool under_track = j >= 3 || j < -3;
        return HeightCell{0.0, 0.0, under_track ? HeightState::known : HeightState::bounded_above};
      },
      0.05};
  const auto solver = posture_solver();
  REQUIRE(solver->look(rails, {}) == Status::ok);
  Posture p;
  REQUIRE(solver->rest(kFolded, p) == Status::ok);
  REQUIRE(p.rest == Rest::stands);
  CHECK(p.clearance_m < 0.2);
}

TEST_CASE("what nobody knows gives no posture, and what is no number a status", "[planner][posture]") {
  const auto solver = posture_solver();
  Posture p;
  CHECK(solver->rest(kFolded, p) == Status::empty);
  for (const HeightState state : {HeightState::unknown, HeightState::bounded_above}) {
    static HeightState said;
    said = state;
    const HeightView view{nullptr,
                          [](const void*, std::int64_t, std::int64_t) {
                            return HeightCell{0, 0, said};
                          },
                          0.05};
    REQUIRE(solver->look(view, {}) == Status::ok);
    REQUIRE(solver->rest(kFolded, p) == Status::ok);
    CHECK(p.rest == Rest::unknown);
    CHECK(p.height_m == 0.0);
    CHECK(p.unknown_share == 1.0);
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const FormulaGround flat{[](double, double) { return 0.0; }};
  CHECK(solver->look(flat.view(), {nan, 0, 0}) == Status::not_finite);
  CHECK(solver->look(flat.view(), {0, 0, nan}) == Status::not_finite);
  CHECK(solver->look(flat.view(), {1e6, 0, 0}) == Status::out_of_range);
  CHECK(solver->look({}, {}) == Status::out_of_range);
  REQUIRE(solver->look(flat.view(), {}) == Status::ok);
  CHECK(solver->rest({{nan, 0, 0, 0}}, p) == Status::not_finite);
  CHECK(solver->rest({{1e9, 0, 0, 0}}, p) == Status::out_of_range);
  CHECK(solver->rest(kFolded, {nan, 0}, p) == Status::not_finite);
  const FormulaGround broken{[nan](double x, double) { return x > 0.1 ? nan : 0.0; }};
  REQUIRE(solver->look(broken.view(), {}) == Status::ok);
  REQUIRE(solver->rest(kFolded, p) == Status::ok);
  CHECK(std::isfinite(p.pitch_rad));
  CHECK(p.unknown_share > 0.1);
  PostureVehicle giant;
  giant.side.flipper_m = 2.0;
  CHECK(PostureSolver(giant, {}).usable() == Status::out_of_range);
  giant.side.flipper_m = PostureVehicle{}.side.flipper_m;
  for (double* const place : {&giant.side.axle_m, &giant.side.pivot_z_m, &giant.side.com_x_m,
                              &giant.side.com_z_m, &giant.belly_z_m, &giant.flipper_com_m}) {
    const double was = *place;
    *place = 1e9;
    CHECK(PostureSolver(giant, {}).usable() == Status::out_of_range);
    *place = was;
  }
  CHECK(PostureSolver(giant, {}).usable() == Status::ok);
  giant.side.flipper_m = nan;
  CHECK(PostureSolver(giant, {}).usable() == Status::not_finite);
}

}  // namespace sortie::planner
