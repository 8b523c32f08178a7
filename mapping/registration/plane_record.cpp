// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_record.hpp"

#include <algorithm>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kHalfTurn_rad = 3.14159265358979323846;
constexpr double kSteps = 32767.0;  ///< of an octahedron's coordinate
constexpr double kCentroidStep_m = 0.001;
constexpr std::int32_t kMostCentroid = (1 << 23) - 1;
constexpr double kSideStep_m = 0.01;
constexpr double kLeastSigma = 1e-5;
constexpr double kLogStep = 0.0953101798043249;  ///< ln 1.1

std::int32_t rounded(double value) { return static_cast<std::int32_t>(rt::floor(value + 0.5)); }

void put(PlaneRecord& record, unsigned at, unsigned bytes, std::uint32_t value) {
  for (unsigned i = 0; i < bytes; ++i) record[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}
std::uint32_t get(const PlaneRecord& record, unsigned at, unsigned bytes) {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < bytes; ++i) value |= std::uint32_t{record[at + i]} << (8 * i);
  return value;
}
std::int32_t get_signed(const PlaneRecord& record, unsigned at, unsigned bytes) {
  const unsigned shift = 32 - 8 * bytes;
  return static_cast<std::int32_t>(get(record, at, bytes) << shift) >> shift;
}

double sign_of(double v) { return v < 0.0 ? -1.0 : 1.0; }

/// The direction that two coordinates on the unfolded octahedron stand for.
rt::Vector3 unfolded(std::int32_t a, std::int32_t b) {
  double x = a / kSteps;
  double y = b / kSteps;
  const double z = 1.0 - std::fabs(x) - std::fabs(y);
  if (z < 0.0) {
    const double folded = (1.0 - std::fabs(y)) * sign_of(x);
    y = (1.0 - std::fabs(x)) * sign_of(y);
    x = folded;
  }
  const rt::Vector3 n{x, y, z};
  return (1.0 / rt::norm(n)) * n;
}

/// Some direction square to a normal, the same for encode() and decode(): along the axis it is least along.
rt::Vector3 reference(const rt::Vector3& n) {
  const double x = std::fabs(n.x);
  const double y = std::fabs(n.y);
  const double z = std::fabs(n.z);
  const rt::Vector3 a = x <= y && x <= z ? rt::Vector3{1, 0, 0}
                        : y <= z         ? rt::Vector3{0, 1, 0}
                                         : rt::Vector3{0, 0, 1};
  const rt::Vector3 square = rt::cross(n, a);
  return (1.0 / rt::norm(square)) * square;
}

std::uint32_t sigma_code(double sigma) {
  return static_cast<std::uint32_t>(std::clamp(rounded(rt::log(sigma / kLeastSigma) / kLogStep), 0, 255));
}
double sigma_of(std::uint32_t code) { return kLeastSigma * rt::exp(kLogStep * code); }
}  // namespace

Status encode(const Plane& plane, PlaneRecord& record) {
  const Status status = check(plane);
  if (status != Status::ok) return status;
  const rt::Vector3& c = plane.centroid_m;
  const double sides[2] = {plane.most_m[0] - plane.least_m[0], plane.most_m[1] - plane.least_m[1]};
  for (const double coordinate : {c.x, c.y, c.z}) {
    if (std::fabs(coordinate) > kCentroidStep_m * kMostCentroid) return Status::out_of_range;
  }
  if (sides[0] > 655.35 || sides[1] > 655.35) return Status::out_of_range;

  const rt::Vector3& n = plane.normal;
  const double scale = 1.0 / (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z));
  double a = scale * n.x;
  double b = scale * n.y;
  if (n.z < 0.0) {
    const double folded = (1.0 - std::fabs(b)) * sign_of(a);
    b = (1.0 - std::fabs(a)) * sign_of(b);
    a = folded;
  }
  const std::int32_t octahedron[2] = {rounded(kSteps * a), rounded(kSteps * b)};
  put(record, 0, 2, static_cast<std::uint32_t>(octahedron[0]));
  put(record, 2, 2, static_cast<std::uint32_t>(octahedron[1]));
  put(record, 4, 3, static_cast<std::uint32_t>(rounded(c.x / kCentroidStep_m)));
  put(record, 7, 3, static_cast<std::uint32_t>(rounded(c.y / kCentroidStep_m)));
  put(record, 10, 3, static_cast<std::uint32_t>(rounded(c.z / kCentroidStep_m)));
  // Against the normal that decode() will see. u and -u are told apart: the sides are not symmetric.
  const rt::Vector3 seen = unfolded(octahedron[0], octahedron[1]);
  const rt::Vector3 e = reference(seen);
  double turn = rt::atan2(rt::dot(rt::cross(seen, e), plane.axis_u), rt::dot(e, plane.axis_u));
  bool backward = false;  // half a turn is enough when the sides change places
  if (turn < 0.0) turn += kHalfTurn_rad, backward = true;
  std::int32_t turns = rounded(turn / kHalfTurn_rad * 65536.0);
  if (turns == 65536) turns = 0, backward = !backward;
  put(record, 13, 2, static_cast<std::uint32_t>(turns));
  const double box = sides[0] * sides[1];
  for (unsigned k = 0; k < 2; ++k) {
    put(record, 15 + 2 * k, 2, static_cast<std::uint32_t>(rounded(sides[k] / kSideStep_m)));
    const double below = backward ? plane.most_m[k] : -plane.least_m[k];
    put(record, 19 + k, 1,
        static_cast<std::uint32_t>(sides[k] > 0.0 ? rounded(255.0 * below / sides[k]) : 0));
  }
  put(record, 21, 1,
      static_cast<std::uint32_t>(box > 0.0 ? rounded(255.0 * std::min(1.0, plane.area_m2 / box)) : 0));
  put(record, 22, 1, sigma_code(plane.sigma_offset_m));
  put(record, 23, 1, sigma_code(plane.sigma_tilt_rad[0]));
  put(record, 24, 1, sigma_code(plane.sigma_tilt_rad[1]));
  put(record, 25, 3, plane.id);
  return Status::ok;
}

Status decode(const PlaneRecord& record, Plane& plane) {
  const std::int32_t a = get_signed(record, 0, 2);
  const std::int32_t b = get_signed(record, 2, 2);
  if (a == -32768 || b == -32768) return Status::malformed;
  Plane p;
  p.normal = unfolded(a, b);
  p.centroid_m = {kCentroidStep_m * get_signed(record, 4, 3), kCentroidStep_m * get_signed(record, 7, 3),
                  kCentroidStep_m * get_signed(record, 10, 3)};
  p.offset_m = rt::dot(p.normal, p.centroid_m);
  const rt::SinCos turn = rt::sincos(get(record, 13, 2) * (kHalfTurn_rad / 65536.0));
  const rt::Vector3 e = reference(p.normal);
  p.axis_u = turn.cos * e + turn.sin * rt::cross(p.normal, e);
  double box = 1.0;
  for (unsigned k = 0; k < 2; ++k) {
    const double side = kSideStep_m * get(record, 15 + 2 * k, 2);
    p.least_m[k] = -side * (get(record, 19 + k, 1) / 255.0);
    p.most_m[k] = side + p.least_m[k];
    box *= side;
  }
  p.area_m2 = box * (get(record, 21, 1) / 255.0);
  p.sigma_offset_m = sigma_of(get(record, 22, 1));
  p.sigma_tilt_rad[0] = sigma_of(get(record, 23, 1));
  p.sigma_tilt_rad[1] = sigma_of(get(record, 24, 1));
  p.id = get(record, 25, 3);
  plane = p;
  return Status::ok;
}

}  // namespace sortie::mapping
