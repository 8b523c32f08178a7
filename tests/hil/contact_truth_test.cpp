// SPDX-License-Identifier: BSD-3-Clause
// The contacts that the plant tells: where they are, what they carry, and that nothing is told twice or lost.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "rt/contact_truth.hpp"
#include "tests/hil/ugv_bench.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

UgvConfig told_on(std::vector<CoursePiece> pieces) {
  UgvConfig config;
  config.contacts = true;
  config.course.pieces = std::move(pieces);
  config.lidar.rate_hz = 0;
  return config;
}

CoursePiece told_piece(CourseKind kind, double x_m) {
  CoursePiece piece;
  piece.kind = kind;
  piece.x_m = x_m;
  return piece;
}

Vec3 vec_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

constexpr double kMu = 0.7;  // of tracks and flippers, the largest there is

// Sums over a record, world axes. Contacts are of the begin of the step.
struct ContactSum {
  ContactSum(const rt::ContactTruth& truth, const Motion& begin) {
    for (const rt::TruthContact& c : truth.contacts) {
      const Vec3 impulse = c.normal_impulse_n_s * vec_of(c.normal) + vec_of(c.friction_impulse_n_s);
      force_n = force_n + (1.0 / rt::to_seconds(truth.step_ns)) * rotate(begin.q_world_body, impulse);
    }
  }
  Vec3 force_n;
};

}  // namespace

TEST_CASE("a vehicle at rest stands on its tracks, and what its contacts carry is its weight") {
  UgvBench bench(told_on({}));
  bench.run(1500, [&](int) { bench.command(0, 0); });
  const Motion before = bench.plant->motion();
  bench.run(1, [&](int) { bench.command(0, 0); });
  rt::ContactTruth truth;
  REQUIRE(bench.plant->contact_truth(truth));
  CHECK(truth.stamp_ns == bench.plant->now_ns());
  CHECK(truth.step_ns == kMs);
  CHECK(truth.dropped == 0);
  REQUIRE(truth.contacts.size() >= 8);
  CHECK(truth.count(rt::VehiclePart::body) == 0);
  CHECK(truth.count(rt::VehiclePart::track_left) == truth.count(rt::VehiclePart::track_right));
  const double mass_kg = dynamic_cast<const TrackedBody&>(bench.plant->body()).plant().model().mass_kg();
  const ContactSum sum(truth, before);
  CHECK(sum.force_n.z == Approx(9.81 * mass_kg).epsilon(1e-3));
  CHECK(std::fabs(sum.force_n.x) < 0.1);
  for (const rt::TruthContact& c : truth.contacts) {
    // In the world they lie on the plane z = 0: the points are from the place that the truth of the pose
    // gives.
    const Vec3 at = before.p_world_body_m + rotate(before.q_world_body, vec_of(c.point_m));
    CHECK(std::fabs(at.z) < 1e-3);
    CHECK(c.penetration_m < 1e-3);
    CHECK(rotate(before.q_world_body, vec_of(c.normal)).z == Approx(1.0));
    CHECK((c.part == rt::VehiclePart::track_left) == (c.point_m[1] > 0));
    CHECK(c.normal_impulse_n_s >= 0);
    CHECK(norm(vec_of(c.friction_impulse_n_s)) <= 1.001 * kMu * c.normal_impulse_n_s + 1e-9);
  }
}

TEST_CASE(
    "over a pallet and stairs every told contact lies on a solid and in the cone, and loads move the robot") {
  UgvBench bench(told_on({told_piece(CourseKind::pallet, 0.8), told_piece(CourseKind::stairs, 3.0)}));
  bench.run(500, [&](int) { bench.command(0, 0); });
  const TrackedPlant& plant = dynamic_cast<const TrackedBody&>(bench.plant->body()).plant();
  const double mass_kg = plant.model().mass_kg();
  std::uint64_t seen[rt::kVehicleParts]{};
  Vec3 impulse_n_s{};
  double seconds = 0;
  const Vec3 speed_before = plant.velocity_world_m_s({});
  for (int i = 0; i < 6000; ++i) {
    const Motion before = bench.plant->motion();
    bench.run(1, [&](int) { bench.command(0.3, 0.3); });
    rt::ContactTruth truth;
    REQUIRE(bench.plant->contact_truth(truth));
    REQUIRE(truth.dropped == 0);
    // An independent count of what is loaded, from the plant's own list.
    std::uint32_t loaded = 0;
    for (const ContactPoint& c : plant.contacts()) loaded += c.grip != Grip::open ? 1 : 0;
    REQUIRE(truth.contacts.size() >= loaded);
    REQUIRE(loaded == plant.report().loaded);
    for (const rt::TruthContact& c : truth.contacts) {
      ++seen[static_cast<std::size_t>(c.part)];
      const Vec3 friction = vec_of(c.friction_impulse_n_s);
      REQUIRE(norm(vec_of(c.normal)) == Approx(1.0));
      REQUIRE(std::fabs(dot(friction, vec_of(c.normal))) < 1e-9 + 1e-9 * c.normal_impulse_n_s);
      REQUIRE(norm(friction) <= 1.001 * kMu * c.normal_impulse_n_s + 1e-6);
      REQUIRE(c.penetration_m < 2e-3);
    }
    impulse_n_s = impulse_n_s + rt::to_seconds(truth.step_ns) * ContactSum(truth, before).force_n;
    seconds += rt::to_seconds(truth.step_ns);
  }
  // Newton: what the contacts gave, less the weight, is the change of momentum. The centre of mass and the
  // origin differ by the turning; at the end of a long drive that is little beside the weight's impulse.
  const Vec3 gained = mass_kg * (plant.velocity_world_m_s({}) - speed_before);
  const double weight_n_s = mass_kg * 9.81 * seconds;
  CHECK(std::fabs(impulse_n_s.z - weight_n_s - gained.z) < 2e-3 * weight_n_s);
  CHECK(seen[static_cast<std::size_t>(rt::VehiclePart::track_left)] > 0);
  CHECK(seen[static_cast<std::size_t>(rt::VehiclePart::flipper_front_left)] > 0);
}

TEST_CASE("flippers are told as they are asked, stand and pull, and a robot without forces tells nothing") {
  UgvBench bench(told_on({}));
  rt::FlipperCommand command;
  const double asked[4] = {0.8, 0.7, -0.05, 0.0};
  bench.run(3000, [&](int) {
    bench.command(0, 0);
    command.stamp_ns = bench.now;
    command.flags = 1;
    for (int i = 0; i < 4; ++i) command.angle_rad[i] = asked[i];
    drivers::CanFrame frames[2];
    REQUIRE(drivers::encode_flippers(command, bench.counter, frames) == Status::ok);
    for (const drivers::CanFrame& frame : frames) REQUIRE(bench.computer->send(frame) == Status::ok);
  });
  rt::ContactTruth truth;
  REQUIRE(bench.plant->contact_truth(truth));
  for (int i = 0; i < 4; ++i) {
    CHECK(truth.flipper_asked_rad[i] == Approx(asked[i]).margin(1.1e-4));  // half a step of the frame
    CHECK(truth.flipper_angle_rad[i] == Approx(asked[i]).margin(0.1));
  }
  CHECK(truth.flipper_torque_n_m[0] > 0);  // holds the tip up against its weight
  rt::FlipperSample heard;
  REQUIRE(bench.plant->body().read_flippers(heard));
  for (int i = 0; i < 4; ++i) {
    CHECK(heard.angle_rad[i] == truth.flipper_angle_rad[i]);
    CHECK(heard.torque_n_m[i] == truth.flipper_torque_n_m[i]);
  }
  UgvBench flat{UgvConfig{}};
  flat.run(5, [&](int) { flat.command(0, 0); });
  CHECK_FALSE(flat.plant->contact_truth(truth));
}
