// SPDX-License-Identifier: BSD-3-Clause
// A plane in 28 bytes: what it loses stays within the bounds that its header states.
#include "mapping/registration/plane_record.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/mapping/plane_scenes.hpp"

namespace {
using namespace sortie;

rt::Vector3 random_unit(tests::WorldRandom& random) {
  for (;;) {
    const double x = random.between(-1, 1);
    const double y = random.between(-1, 1);
    const rt::Vector3 v{x, y, random.between(-1, 1)};
    const double length = rt::norm(v);
    if (length > 0.1 && length < 1.0) return (1.0 / length) * v;
  }
}

mapping::Plane random_plane(tests::WorldRandom& random) {
  const rt::Vector3 n = random_unit(random);
  const double x = random.between(-8388, 8388);
  const double y = random.between(-8388, 8388);
  const rt::Vector3 c{x, y, random.between(-8388, 8388)};
  mapping::Plane p =
      tests::rectangle(n, c, random_unit(random), random.between(0.01, 300), random.between(0.01, 300));
  for (int k = 0; k < 2; ++k) {
    const double part = random.between(0, 1);
    const double side = p.most_m[k] - p.least_m[k];
    p.least_m[k] = -part * side;
    p.most_m[k] = (1 - part) * side;
    p.sigma_tilt_rad[k] = std::exp(random.between(-11, 12));
  }
  p.area_m2 *= random.between(0, 1);
  p.sigma_offset_m = std::exp(random.between(-11, 12));
  p.id = random.below(1u << 24);
  return p;
}

double angle(const rt::Vector3& a, const rt::Vector3& b) {
  return std::atan2(rt::norm(rt::cross(a, b)), rt::dot(a, b));
}
}  // namespace

TEST_CASE("A plane's record loses no more than its bounds") {
  constexpr std::uint32_t kSeed = 1;
  tests::WorldRandom random(kSeed);
  CAPTURE(kSeed);
  double worst_normal = 0, worst_axis = 0, worst_centroid = 0, worst_side = 0, worst_corner = 0,
         worst_sigma = 0;
  for (int i = 0; i < 20000; ++i) {
    const mapping::Plane p = random_plane(random);
    mapping::PlaneRecord record{};
    mapping::Plane q;
    REQUIRE(mapping::encode(p, record) == Status::ok);
    REQUIRE(mapping::decode(record, q) == Status::ok);
    REQUIRE(mapping::check(q) == Status::ok);
    worst_normal = std::max(worst_normal, angle(p.normal, q.normal));
    const double turned = angle(p.axis_u, q.axis_u);  // or half a turn, sides exchanged
    const bool backward = turned > 1.5;
    worst_axis = std::max(worst_axis, backward ? 3.14159265358979 - turned : turned);
    for (const double d :
         {p.centroid_m.x - q.centroid_m.x, p.centroid_m.y - q.centroid_m.y, p.centroid_m.z - q.centroid_m.z})
      worst_centroid = std::max(worst_centroid, std::fabs(d));
    for (int k = 0; k < 2; ++k) {
      const double side = p.most_m[k] - p.least_m[k];
      worst_side = std::max(worst_side, std::fabs(q.most_m[k] - q.least_m[k] - side));
      const double most = backward ? -q.least_m[k] : q.most_m[k];
      worst_corner = std::max(worst_corner, (std::fabs(most - p.most_m[k]) - 0.005) / side);
      worst_sigma = std::max(worst_sigma, std::fabs(q.sigma_tilt_rad[k] / p.sigma_tilt_rad[k] - 1));
    }
    worst_sigma = std::max(worst_sigma, std::fabs(q.sigma_offset_m / p.sigma_offset_m - 1));
    const double box = (p.most_m[0] - p.least_m[0]) * (p.most_m[1] - p.least_m[1]);
    const double box_of_record = (q.most_m[0] - q.least_m[0]) * (q.most_m[1] - q.least_m[1]);
    if (box > 1.0) CHECK(std::fabs(q.area_m2 / box_of_record - p.area_m2 / box) < 0.5 / 255 + 1e-9);
    CHECK(q.id == p.id);
  }
  CHECK(worst_normal <= mapping::kRecordNormal_rad);
  CHECK(worst_axis <= mapping::kRecordAxis_rad);
  CHECK(worst_centroid <= mapping::kRecordCentroid_m + 1e-9);
  CHECK(worst_side <= mapping::kRecordSide_m + 1e-9);
  CHECK(worst_corner <= 0.5 / 255 + 1e-9);
  CHECK(worst_sigma <= mapping::kRecordSigma);
  // Bounds that nothing comes near to would say nothing.
  CHECK(worst_normal > 0.7 * mapping::kRecordNormal_rad);
  CHECK(worst_axis > 0.5 * mapping::kRecordAxis_rad);
}

TEST_CASE("Any 28 bytes are a good plane or malformed, and axes along the frame come back as they are") {
  tests::WorldRandom random(2);
  std::uint32_t malformed = 0;
  for (int i = 0; i < 20000; ++i) {
    mapping::PlaneRecord record;
    for (std::uint8_t& byte : record) byte = static_cast<std::uint8_t>(random.below(256));
    if (i % 100 == 0) record[0] = 0, record[1] = 0x80;
    mapping::Plane p;
    const Status status = mapping::decode(record, p);
    if (status == Status::ok)
      REQUIRE(mapping::check(p) == Status::ok);
    else
      ++malformed;
  }
  CHECK(malformed >= 200);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const double n[3] = {axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0};
      const mapping::Plane p = tests::rectangle({n[0], n[1], n[2]}, {1, 2, 3}, {n[1], n[2], n[0]}, 2, 1);
      mapping::PlaneRecord record{};
      mapping::Plane q;
      REQUIRE(mapping::encode(p, record) == Status::ok);
      REQUIRE(mapping::decode(record, q) == Status::ok);
      CHECK(angle(p.normal, q.normal) < 1e-12);
    }
  }
}

TEST_CASE("A record refuses what it cannot hold, and leaves its bytes alone") {
  const mapping::Plane good = tests::rectangle({0, 0, 1}, {1, 2, 3}, {1, 0, 0}, 2, 1);
  const auto refused = [](mapping::Plane p) {
    mapping::PlaneRecord record{};
    record[3] = 77;
    const Status status = mapping::encode(p, record);
    CHECK(record[3] == 77);
    return status;
  };
  mapping::Plane p = good;
  p.normal.x = std::numeric_limits<double>::quiet_NaN();
  CHECK(refused(p) == Status::not_finite);
  p = good;
  p.normal = {0, 0.1, 1};
  CHECK(refused(p) == Status::out_of_range);
  p = good;
  p.offset_m += 0.01;  // not through its centroid
  CHECK(refused(p) == Status::out_of_range);
  CHECK(refused(tests::rectangle({0, 0, 1}, {9000, 0, 0}, {1, 0, 0}, 2, 1)) == Status::out_of_range);
  CHECK(refused(tests::rectangle({0, 0, 1}, {0, 0, 0}, {1, 0, 0}, 400, 1)) == Status::out_of_range);
  p = good;
  p.sigma_offset_m = 0;
  CHECK(refused(p) == Status::out_of_range);
}

TEST_CASE("The 4x4 information of a plane is the inverse of its covariance, by differences") {
  tests::WorldRandom random(3);
  const mapping::Plane p = tests::rectangle({0.3, -0.5, 0.8}, {4, -7, 2}, {1, 0.2, 0}, 2, 1);
  mapping::Plane q = p;
  q.sigma_offset_m = 0.02;
  q.sigma_tilt_rad[0] = 0.003;
  q.sigma_tilt_rad[1] = 0.007;
  const mapping::PlaneInformation information = mapping::information_of(q);
  // Each of the three independent errors, of one standard deviation, is worth 1.
  const rt::Vector3 axes[2] = {q.axis_u, q.axis_v()};
  for (int k = 0; k < 3; ++k) {
    rt::Vector3 n = q.normal;
    double d = q.offset_m;
    if (k < 2) {
      n = rt::rotate(rt::exp_rotation(q.sigma_tilt_rad[k] * axes[k]), n);
      d = rt::dot(n, q.centroid_m);
    } else {
      d += q.sigma_offset_m;
    }
    const double change[4] = {n.x - q.normal.x, n.y - q.normal.y, n.z - q.normal.z, d - q.offset_m};
    double worth = 0.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) worth += change[i] * information.m[4 * i + j] * change[j];
    }
    CHECK(worth == Approx(1.0).epsilon(1e-3));
  }
}
