// SPDX-License-Identifier: BSD-3-Clause
// Rotations against closed forms and long-double twins, with the corners: zero, tiny, near pi, opposite.
#include "rt/rotation.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

namespace {
using namespace sortie::rt;

struct Uniform {
  std::uint64_t state;
  double operator()() {  // uniform in [-1, 1)
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(static_cast<std::int64_t>(state >> 11)) * 0x1p-52 - 1.0;
  }
  Vector3 vector() {
    const double x = (*this)();
    const double y = (*this)();
    const double z = (*this)();
    return {x, y, z};
  }
};

double distance(const Quaternion& a, const Quaternion& b) { return norm(log_rotation(conjugate(a) * b)); }
double distance(const Vector3& a, const Vector3& b) { return norm(a - b); }
constexpr double kPi = 3.141592653589793;
}  // namespace

TEST_CASE("The exponential map agrees with a long-double twin from 1e-12 rad to many turns") {
  Uniform random{7};
  for (int power = -120; power <= 15; ++power) {
    const double angle = std::pow(10.0, 0.1 * power);
    const Vector3 axis = random.vector();
    const Vector3 phi = (angle / norm(axis)) * axis;
    const Quaternion q = exp_rotation(phi);
    const long double t =
        std::sqrt(static_cast<long double>(phi.x) * phi.x + static_cast<long double>(phi.y) * phi.y +
                  static_cast<long double>(phi.z) * phi.z);
    const long double s = std::sin(t / 2) / t;
    INFO("angle " << angle);
    CHECK(std::fabs(static_cast<double>(q.w - std::cos(t / 2))) < 2e-15);
    CHECK(std::fabs(static_cast<double>(q.x - s * phi.x)) < 2e-15);
    CHECK(std::fabs(static_cast<double>(q.z - s * phi.z)) < 2e-15);
    if (angle < 1.0)  // relative precision, too, where the vector part is small
      CHECK(std::fabs(static_cast<double>(q.y - s * phi.y)) <= 4e-16 * angle);
  }
}

TEST_CASE("The logarithm undoes the exponential map, near zero and near pi as well") {
  Uniform random{11};
  for (const double angle : {0.0, 1e-300, 1e-160, 1e-12, 9.9e-5, 1.1e-4, 2.1e-4, 0.1, 1.0, 3.0, kPi - 1e-3,
                             kPi - 1e-6, kPi - 1e-9, kPi - 1e-12}) {
    const Vector3 axis = random.vector();
    const Vector3 phi = (angle / norm(axis)) * axis;
    const Vector3 back = log_rotation(exp_rotation(phi));
    INFO("angle " << angle);
    CHECK(distance(back, phi) <= 1e-15 * (angle + (angle > 3 ? 3.0 : 0.0)));
    const Quaternion q = exp_rotation(phi);
    const Vector3 mirrored = log_rotation({-q.w, -q.x, -q.y, -q.z});
    CHECK(distance(mirrored, phi) <= 1e-15 * (angle + (angle > 3 ? 3.0 : 0.0)));
  }
}

TEST_CASE("Quaternion, matrix and vector rotation say the same") {
  Uniform random{23};
  for (int i = 0; i < 2000; ++i) {
    const Quaternion a = exp_rotation(4.0 * random.vector());
    const Quaternion b = exp_rotation(4.0 * random.vector());
    const Vector3 v = 10.0 * random.vector();
    REQUIRE(distance(rotate(a * b, v), rotate(a, rotate(b, v))) < 1e-13);
    REQUIRE(distance(to_matrix(a) * v, rotate(a, v)) < 1e-13);
    REQUIRE(distance(rotate_back(a, rotate(a, v)), v) < 1e-13);
    REQUIRE(distance(from_matrix(to_matrix(a)), a) < 1e-15 * 10);
    REQUIRE(std::fabs(norm(rotate(a, v)) - norm(v)) < 1e-13);
  }
}

TEST_CASE("A matrix of half a turn about any axis gives the right quaternion") {
  for (const Vector3 axis : {Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, 0, 1}, Vector3{0.6, 0, 0.8},
                             Vector3{-0.48, 0.6, 0.64}}) {
    const Quaternion q{0, axis.x, axis.y, axis.z};
    CHECK(distance(from_matrix(to_matrix(q)), q) < 1e-15 * 4);
  }
}

TEST_CASE("Yaw, pitch and roll come back as they went in, and stay finite straight up") {
  Uniform random{31};
  for (int i = 0; i < 2000; ++i) {
    const double yaw = 3.14 * random();
    const double pitch = 1.55 * random();
    const double roll = 3.14 * random();
    const Quaternion q = from_yaw_pitch_roll(yaw, pitch, roll);
    REQUIRE(std::fabs(yaw_of(q) - yaw) < 1e-13);
    REQUIRE(std::fabs(pitch_of(q) - pitch) < 1e-13);
    REQUIRE(std::fabs(roll_of(q) - roll) < 1e-13);
  }
  const Quaternion up = from_yaw_pitch_roll(0.3, -0.5 * kPi, 0.2);
  CHECK(std::isfinite(yaw_of(up)));
  CHECK(std::fabs(pitch_of(up) + 0.5 * kPi) < 1e-7);
  CHECK(rotate(from_yaw_pitch_roll(0, -0.1, 0), {1, 0, 0}).z > 0.0);  // negative pitch lifts the nose
  CHECK(rotate(from_yaw_pitch_roll(0.1, 0, 0), {1, 0, 0}).y > 0.0);   // positive yaw turns left
}

TEST_CASE("Slerp meets both ends, is halfway in the middle, takes the short way and extrapolates") {
  Uniform random{41};
  for (int i = 0; i < 500; ++i) {
    const Quaternion a = exp_rotation(2.0 * random.vector());
    const Vector3 phi = random.vector();
    Quaternion b = a * exp_rotation(phi);
    if (i % 2 == 1) b = {-b.w, -b.x, -b.y, -b.z};
    REQUIRE(distance(slerp(a, b, 0), a) < 1e-14);
    REQUIRE(distance(slerp(a, b, 1), b) < 1e-14);
    REQUIRE(distance(slerp(a, b, 0.5), a * exp_rotation(0.5 * phi)) < 1e-14);
    REQUIRE(distance(slerp(a, b, 1.5), a * exp_rotation(1.5 * phi)) < 1e-14);
    REQUIRE(distance(slerp(a, a, 0.3), a) < 1e-14);
  }
}

TEST_CASE("The rotation between two directions is exact for equal, near and opposite ones") {
  Uniform random{43};
  for (int i = 0; i < 500; ++i) {
    const Vector3 a = random.vector();
    const Vector3 b = 5.0 * random.vector();
    const Vector3 turned = rotate(rotation_between(a, b), a);
    REQUIRE(distance((1.0 / norm(turned)) * turned, (1.0 / norm(b)) * b) < 1e-13);
    const Vector3 half = rotate(rotation_between(a, -3.0 * a), a);
    REQUIRE(distance(half, -1.0 * a) < 1e-13);
  }
  CHECK(distance(rotation_between({0, 0, 2}, {0, 0, 3}), Quaternion{}) == 0.0);
}

TEST_CASE("Normalising rubbish gives no rotation, never a NaN") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Quaternion bad :
       {Quaternion{0, 0, 0, 0}, Quaternion{nan, 0, 0, 0}, Quaternion{1e200, 0, 0, 1e200},
        Quaternion{0, std::numeric_limits<double>::infinity(), 0, 0}}) {
    const Quaternion q = normalised(bad);
    CHECK(q.w == 1.0);
    CHECK(q.x == 0.0);
  }
}

TEST_CASE("Angles wrap to one turn") {
  CHECK(wrap_angle(0.0) == 0.0);
  CHECK(std::fabs(wrap_angle(2 * kPi + 0.5) - 0.5) < 1e-14);
  CHECK(std::fabs(wrap_angle(-2 * kPi - 0.5) + 0.5) < 1e-14);
  CHECK(wrap_angle(kPi) > 0.0);
  CHECK(wrap_angle(-kPi) > 0.0);
  CHECK(std::fabs(wrap_angle(1000 * kPi + 0.25) - 0.25) < 1e-12);
}
