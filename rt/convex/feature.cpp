// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/feature.hpp"

#include <cmath>

#include "rt/convex/local.hpp"

namespace sortie::rt::convex {
namespace {

constexpr double kCosFace = 0.9659;  // 15 deg: a face, or an edge, counts as facing a direction within this
constexpr double kSinEdge = 0.2588;

// Names of features: one range a kind.
constexpr std::uint8_t kFace = 0;
constexpr std::uint8_t kEdge = 32;
constexpr std::uint8_t kPoint = 64;

struct Builder {
  const Convex& body;
  Feature out{};
  void add(double x, double y, double z, unsigned id) {
    out.vertices_m[out.count] = to_world(body, {x, y, z});
    out.ids[out.count] = static_cast<std::uint8_t>(id);
    ++out.count;
  }
};

void box_face(Builder& make, const Vector3& d, int axis) {
  const double half[3] = {make.body.half_m.x, make.body.half_m.y, make.body.half_m.z};
  const double dir[3] = {d.x, d.y, d.z};
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const bool positive = dir[axis] >= 0.0;
  for (unsigned corner = 0; corner < 4; ++corner) {
    const unsigned turn = positive ? corner : 3u - corner;  // counter-clockwise seen from outside
    double p[3];
    p[axis] = positive ? half[axis] : -half[axis];
    p[u] = turn == 0 || turn == 3 ? -half[u] : half[u];
    p[v] = turn < 2 ? -half[v] : half[v];
    make.add(p[0], p[1], p[2], turn);
  }
  make.out.flat = true;
  make.out.normal = (positive ? 1.0 : -1.0) * axis_of(make.body, axis);
  make.out.id = static_cast<std::uint8_t>(kFace + 2 * axis + (positive ? 0 : 1));
}

Feature box_feature(const Convex& body, const Vector3& d) {
  Builder make{body};
  const double dir[3] = {d.x, d.y, d.z};
  const double size[3] = {std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)};
  const int most = size[0] >= size[1] ? (size[0] >= size[2] ? 0 : 2) : (size[1] >= size[2] ? 1 : 2);
  if (size[most] >= kCosFace) {
    box_face(make, d, most);
    return make.out;
  }
  const int least = size[0] <= size[1] ? (size[0] <= size[2] ? 0 : 2) : (size[1] <= size[2] ? 1 : 2);
  const double half[3] = {body.half_m.x, body.half_m.y, body.half_m.z};
  double p[3];
  unsigned corner = 0;
  for (int i = 0; i < 3; ++i) {
    p[i] = dir[i] >= 0.0 ? half[i] : -half[i];
    // Not a shifted choice: GCC 12's shift check would look at a variable that one branch leaves unset.
    if (!(dir[i] >= 0.0)) corner |= 1u << static_cast<unsigned>(i);
  }
  if (size[least] < kSinEdge) {
    const unsigned bit = 1u << static_cast<unsigned>(least);
    p[least] = -half[least];
    make.add(p[0], p[1], p[2], corner | bit);
    p[least] = half[least];
    make.add(p[0], p[1], p[2], corner & ~bit);
    make.out.id = static_cast<std::uint8_t>(kEdge + 8u * static_cast<unsigned>(least) + (corner & ~bit));
  } else {
    make.add(p[0], p[1], p[2], corner);
    make.out.id = static_cast<std::uint8_t>(kPoint + corner);
  }
  return make.out;
}

// The flat side of a track as an eight-cornered outline: the runs' ends, and two points on each wheel.
void track_side(Builder& make, bool left) {
  const Convex& t = make.body;
  const double nx = t.run_normal[0];
  const double nz = t.run_normal[1];
  const double y = left ? t.half_m.y : -t.half_m.y;
  // Directions from the wheels' axes, counter-clockwise from the lower run, in the x-z plane seen from -y.
  double dir[8][2] = {{nx, -nz}, {nx + 2.0, -nz}, {nx + 2.0, nz},  {nx, nz},
                      {nx, nz},  {nx - 2.0, nz},  {nx - 2.0, -nz}, {nx, -nz}};
  if (t.length_m == 0.0) {  // one wheel: eight points evenly around it, 22.5 deg off the axes
    constexpr double kLong = 0.92387953251128674;
    constexpr double kShort = 0.38268343236508977;
    const double even[8][2] = {{kShort, -kLong}, {kLong, -kShort}, {kLong, kShort},   {kShort, kLong},
                               {-kShort, kLong}, {-kLong, kShort}, {-kLong, -kShort}, {-kShort, -kLong}};
    for (int i = 0; i < 8; ++i) {
      dir[i][0] = even[i][0];
      dir[i][1] = even[i][1];
    }
  }
  for (unsigned i = 0; i < 8; ++i) {
    const unsigned k = left ? 7u - i : i;
    const double inverse = 1.0 / std::sqrt(dir[k][0] * dir[k][0] + dir[k][1] * dir[k][1]);
    const double r = t.radius_m[k < 4 ? 1 : 0] * inverse;
    const double x = t.first_x_m + (k < 4 ? t.length_m : 0.0);
    make.add(x + r * dir[k][0], y, r * dir[k][1], k);
  }
  make.out.flat = true;
  make.out.normal = (left ? 1.0 : -1.0) * axis_of(t, 1);
  make.out.id = static_cast<std::uint8_t>(kFace + (left ? 0 : 1));
}

// (x, z): unit direction in the plane of the wheels. The run that faces it reaches from the line of the wheel
// that supports there, which is where the body touches first, to the other wheel's end of the run.
struct Profile {
  double x[2];  // of wheel 0's line and of wheel 1's
  double z[2];
  bool run;   // the run faces the direction; else only the line of `wheel` does
  int wheel;  // the wheel that supports
};

Profile profile(const Convex& t, double x, double z) {
  Profile p{};
  const double run_z = z >= 0.0 ? t.run_normal[1] : -t.run_normal[1];
  p.wheel = t.length_m * x + t.radius_m[1] > t.radius_m[0] ? 1 : 0;
  p.run = t.length_m > 0.0 && x * t.run_normal[0] + z * run_z >= kCosFace;
  for (int i = 0; i < 2; ++i) {
    const bool supports = i == p.wheel;
    const double r = t.radius_m[i];
    p.x[i] = t.first_x_m + (i == 1 ? t.length_m : 0.0) + r * (supports ? x : t.run_normal[0]);
    p.z[i] = r * (supports ? z : run_z);
  }
  return p;
}

Feature track_feature(const Convex& t, const Vector3& d) {
  Builder make{t};
  if (std::fabs(d.y) >= kCosFace) {
    track_side(make, d.y >= 0.0);
    return make.out;
  }
  const double inverse = 1.0 / std::sqrt(d.x * d.x + d.z * d.z);  // > sin(15 deg)
  const bool upper = d.z >= 0.0;
  const Profile p = profile(t, d.x * inverse, d.z * inverse);
  const double w = t.half_m.y;
  const unsigned side = d.y >= 0.0 ? 0u : 1u;
  const unsigned half = upper ? 0u : 1u;
  const auto wheel = static_cast<unsigned>(p.wheel);
  if (std::fabs(d.y) >= kSinEdge) {  // the rim: a straight piece along the run, or one point
    const double y = side == 0 ? w : -w;
    if (p.run) {
      make.add(p.x[0], y, p.z[0], 0);
      make.add(p.x[1], y, p.z[1], 1);
      make.out.id = static_cast<std::uint8_t>(kEdge + 2u * side + half);
    } else {
      make.add(p.x[wheel], y, p.z[wheel], 0);
      make.out.id = static_cast<std::uint8_t>(kPoint + 2u * side + wheel);
    }
    return make.out;
  }
  if (!p.run) {
    make.add(p.x[wheel], -w, p.z[wheel], 0);
    make.add(p.x[wheel], w, p.z[wheel], 1);
    make.out.id = static_cast<std::uint8_t>(kEdge + 8u + wheel);
    return make.out;
  }
  const double y = upper ? w : -w;  // counter-clockwise seen from outside
  make.add(p.x[0], -y, p.z[0], 0);
  make.add(p.x[1], -y, p.z[1], 1);
  make.add(p.x[1], y, p.z[1], 2);
  make.add(p.x[0], y, p.z[0], 3);
  const Vector3 square =
      cross(make.out.vertices_m[1] - make.out.vertices_m[0], make.out.vertices_m[2] - make.out.vertices_m[1]);
  make.out.flat = normalise(square, make.out.normal);
  make.out.id = static_cast<std::uint8_t>(kFace + 2u + half);
  return make.out;
}

Feature ellipsoid_feature(const Convex& e, const Vector3& d) {
  Builder make{e};
  const Vector3 stretched{e.half_m.x * d.x, e.half_m.y * d.y, e.half_m.z * d.z};
  const double s = 1.0 / norm(stretched);
  const Vector3 p{e.half_m.x * (s * stretched.x), e.half_m.y * (s * stretched.y),
                  e.half_m.z * (s * stretched.z)};
  const Vector3& w = e.sweep_m;
  const double along = dot(w, d);
  if (along * along < kSinEdge * kSinEdge * dot(w, w)) {
    make.add(p.x - w.x, p.y - w.y, p.z - w.z, 0);
    make.add(p.x + w.x, p.y + w.y, p.z + w.z, 1);
    make.out.id = kEdge;
    return make.out;
  }
  const double sign = along >= 0.0 ? 1.0 : -1.0;
  make.add(p.x + sign * w.x, p.y + sign * w.y, p.z + sign * w.z, 0);
  make.out.id = static_cast<std::uint8_t>(kPoint + (along >= 0.0 ? 0 : 1));
  return make.out;
}

}  // namespace

Feature feature(const Convex& body, const Vector3& dir_world) {
  Vector3 d = to_body(body, dir_world);
  if (!normalise(d, d)) d = {0.0, 0.0, 1.0};  // a zero direction or a NaN: some feature
  switch (body.kind) {
    case Kind::box:
      return box_feature(body, d);
    case Kind::track:
      return track_feature(body, d);
    case Kind::swept_ellipsoid:
      return ellipsoid_feature(body, d);
    case Kind::none:
      break;
  }
  Feature point;
  point.vertices_m[0] = body.p_world_m;
  point.count = 1;
  return point;
}

}  // namespace sortie::rt::convex
