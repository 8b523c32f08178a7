// SPDX-License-Identifier: BSD-3-Clause
// Contact manifolds: where a vehicle stands, which way its ground pushes, and that nothing flickers.
#include "rt/convex/manifold.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "rt/convex/feature.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/rt/convex_oracle.hpp"

namespace sortie::rt::convex::test {
namespace {

constexpr double kHalf = 1.5707963267948966;

Convex at(Convex body, const Vector3& p, const Quaternion& q = {}) {
  place(body, p, q);
  return body;
}

const Convex kTrack = make_track(0.09047, 0.09047, 0.5, 0.04865);
const Convex kFlipper = make_track(0.089, 0.029, 0.33, 0.0249);

}  // namespace

TEST_CASE("convex: a track lies on the ground with four contacts that push it up") {
  const Convex floor = at(make_box({3, 3, 0.5}), {0.7, 0.4, -0.5});
  const Convex track = at(kTrack, {0, 0, 0.0897});
  const Manifold on_box = manifold(track, floor);
  const Manifold on_plane = manifold(track, HalfSpace{});
  REQUIRE(on_box.count == 4);
  REQUIRE(on_plane.count == 4);
  std::set<std::uint32_t> ids;
  double x = 0;
  for (const Manifold* m : {&on_box, &on_plane}) {
    CHECK(m->state == State::penetrating);
    for (std::uint32_t i = 0; i < 4; ++i) {
      CHECK(m->contacts[i].normal.z == Approx(1.0));
      CHECK(m->contacts[i].depth_m == Approx(0.00077).margin(1e-9));
      CHECK(std::fabs(m->contacts[i].point_m.y) == Approx(0.04865));
      CHECK(m->contacts[i].point_m.z == Approx(-0.000385).margin(1e-9));
      x += m->contacts[i].point_m.x;
    }
  }
  CHECK(x == Approx(2.0));
  for (std::uint32_t i = 0; i < 4; ++i) ids.insert(on_box.contacts[i].id);
  CHECK(ids.size() == 4);
  // The other way round the normal turns, the points and depths stay.
  const Manifold turned = manifold(floor, track);
  REQUIRE(turned.count == 4);
  CHECK(turned.contacts[0].normal.z == Approx(-1.0));
  CHECK(turned.contacts[0].depth_m == Approx(0.00077).margin(1e-9));
}

TEST_CASE("convex: a ground of a plane and one of a large box give the same contacts") {
  Draw draw(77);
  const Convex floor = at(make_box({20, 20, 1}), {0, 0, -1});
  int compared = 0;
  for (int i = 0; i < 3000; ++i) {
    const double pitch = draw.within(-0.1, 0.1);
    const double roll = draw.within(-0.1, 0.1);
    const double yaw = draw.within(-3, 3);
    Convex body = i % 2 == 0 ? kTrack : kFlipper;
    place(body, {}, from_yaw_pitch_roll(yaw, pitch, roll));
    const double depth = draw.within(-0.0005, 0.002);
    body.p_world_m.z = -depth + reach_by_parts(body, {0, 0, -1});
    const Manifold plane = manifold(body, HalfSpace{});
    const Manifold box = manifold(body, floor);
    REQUIRE(plane.count == box.count);
    CHECK(plane.state == box.state);
    ++compared;
    double sum[2]{};
    double deepest = -1;
    for (std::uint32_t k = 0; k < plane.count; ++k) {
      sum[0] += plane.contacts[k].depth_m + plane.contacts[k].point_m.x * 3 + plane.contacts[k].point_m.y * 5;
      sum[1] += box.contacts[k].depth_m + box.contacts[k].point_m.x * 3 + box.contacts[k].point_m.y * 5;
      deepest = std::max(deepest, box.contacts[k].depth_m);
    }
    CHECK(sum[0] == Approx(sum[1]).margin(1e-7));
    CHECK(deepest == Approx(depth).margin(1e-7));
  }
  CHECK(compared == 3000);
}

TEST_CASE("convex: a wheel rolls over a stair's nose on two contacts whose normal turns with it") {
  const Convex stair = at(make_box({0.5, 1, 0.1}), {0.5, 0, -0.1});  // its nose lies on the y axis
  for (double angle = 0.3; angle < 1.3; angle += 0.05) {
    const SinCos s = sincos(angle);  // of the wheel's axis over the nose, from straight ahead
    const double r = 0.09047 - 0.0005;
    const Convex track = at(kTrack, {-r * s.cos, 0, r * s.sin}, from_yaw_pitch_roll(0, -kHalf, 0));
    const Manifold m = manifold(track, stair);
    INFO("angle " << angle);
    REQUIRE(m.count == 2);
    for (std::uint32_t i = 0; i < 2; ++i) {
      CHECK(m.contacts[i].normal.x == Approx(-s.cos).margin(1e-9));
      CHECK(m.contacts[i].normal.z == Approx(s.sin).margin(1e-9));
      CHECK(m.contacts[i].depth_m == Approx(0.0005).margin(1e-8));
      CHECK(std::fabs(m.contacts[i].point_m.y) == Approx(0.04865).margin(1e-4));
    }
  }
}

TEST_CASE("convex: contacts exist up to the margin and no further") {
  const Convex floor = at(make_box({3, 3, 0.5}), {0, 0, -0.5});
  ManifoldOptions options;
  options.margin_m = 0.004;
  CHECK(manifold(at(kTrack, {0, 0, 0.09047 + 0.0039}), floor, options).count == 4);
  CHECK(manifold(at(kTrack, {0, 0, 0.09047 + 0.0041}), floor, options).count == 0);
  const Manifold near = manifold(at(kTrack, {0, 0, 0.09047 + 0.003}), HalfSpace{}, options);
  REQUIRE(near.count == 4);
  CHECK(near.state == State::separated);
  CHECK(near.contacts[0].depth_m == Approx(-0.003).margin(1e-9));
  // Corner to corner, the true distance counts, not that along an axis.
  const Convex a = at(make_box({0.1, 0.1, 0.1}), {0.203, 0.203, 0.203});
  const Convex b = make_box({0.1, 0.1, 0.1});
  options.margin_m = 0.0051;
  CHECK(manifold(a, b, options).count == 0);
  options.margin_m = 0.0053;
  const Manifold corner = manifold(a, b, options);
  REQUIRE(corner.count == 1);
  CHECK(corner.contacts[0].depth_m == Approx(-0.003 * std::sqrt(3.0)).margin(1e-8));
  CHECK(corner.contacts[0].point_m.x == Approx(0.1015).margin(1e-6));
}

TEST_CASE("convex: every contact lies between two points of the bodies, and ids never repeat") {
  Draw draw(78);
  long contacts = 0;
  long rough = 0;
  for (int i = 0; i < 6000; ++i) {
    Convex a = draw.chance(0.7) ? any_track(draw) : any_box(draw);
    Convex b = any_box(draw);
    b.R_world_body = to_matrix(draw.turn());
    const double overlap = draw.within(-0.001, 0.003);
    put_shallow(draw, a, b, overlap);
    ManifoldOptions options;
    options.max_contacts = 4u + static_cast<std::uint32_t>(draw.below(5));
    const Manifold m = manifold(a, b, options);
    REQUIRE(m.count <= options.max_contacts);
    if (m.state != State::separated) REQUIRE(m.count > 0);
    std::set<std::uint32_t> ids;
    double deepest = -1.0;
    for (std::uint32_t k = 0; k < m.count; ++k) {
      const Contact& c = m.contacts[k];
      CHECK(std::fabs(norm(c.normal) - 1.0) < 1e-12);
      CHECK(c.depth_m >= -options.margin_m);
      const Vector3 on_a = c.point_m - 0.5 * c.depth_m * c.normal;
      const Vector3 on_b = c.point_m + 0.5 * c.depth_m * c.normal;
      const double off = std::max(norm(nearest_in(a, on_a) - on_a), norm(nearest_in(b, on_b) - on_b));
      if (c.id == 0xffffffffu) {  // nearest points, as exact as the search for them
        rough += off > 3e-4 ? 1 : 0;
      } else {
        CHECK(off < 3e-4);  // edges within 6 deg count as parallel: up to 0.25 mm beside each other
      }
      ids.insert(c.id);
      deepest = std::max(deepest, c.depth_m);
      ++contacts;
    }
    CHECK(ids.size() == m.count);
    if (m.count > 0) CHECK(deepest <= overlap_by_parts(a, b, m.contacts[0].normal) + 1e-9);
  }
  CHECK(contacts > 6000);
  INFO(rough << " of " << contacts);
  CHECK(rough * 100 < contacts);
}

TEST_CASE("convex: names of contacts stay while a track slides, turns and settles") {
  const Convex floor = at(make_box({3, 3, 0.5}), {0, 0, -0.5});
  std::set<std::uint32_t> ids;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.01 * i;
    const Manifold m = manifold(at(kTrack, {0.1 * t, 0.05 * t, 0.0902},
                                   from_yaw_pitch_roll(0.2 * t, 1e-4 * (i % 5 - 2), 1e-4 * (i % 3 - 1))),
                                floor);
    REQUIRE(m.count == 4);
    for (std::uint32_t k = 0; k < m.count; ++k) ids.insert(m.contacts[k].id);
  }
  CHECK(ids.size() == 4);
}

TEST_CASE("convex: features go round counter-clockwise and lie on the body") {
  Draw draw(79);
  for (int i = 0; i < 2000; ++i) {
    Convex body = i % 2 == 0 ? any_box(draw) : any_track(draw);
    body.R_world_body = to_matrix(draw.turn());
    const Vector3 d = draw.direction();
    const Feature f = feature(body, i % 3 == 0 ? column(body, i % 3) : d);
    REQUIRE(f.count >= 1);
    double farthest = -1e300;
    for (std::uint32_t k = 0; k < f.count; ++k) {
      CHECK(norm(nearest_in(body, f.vertices_m[k]) - f.vertices_m[k]) < 1e-9);
      farthest = std::max(farthest, dot(f.vertices_m[k], i % 3 == 0 ? column(body, i % 3) : d));
    }
    if (!f.flat) continue;
    const Vector3 e1 = f.vertices_m[1] - f.vertices_m[0];
    const Vector3 e2 = f.vertices_m[f.count - 1] - f.vertices_m[0];
    CHECK(dot(cross(e1, e2), f.normal) > 0.0);
    CHECK(dot(f.normal, i % 3 == 0 ? column(body, i % 3) : d) > 0.9);
  }
}

TEST_CASE("convex: queries and manifolds take no memory from the heap") {
  if (!posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  Draw draw(80);
  std::vector<Convex> bodies;
  for (int i = 0; i < 200; ++i) {
    Convex b = any_box(draw);
    Convex a = any_track(draw);
    b.R_world_body = to_matrix(draw.turn());
    put_shallow(draw, a, b, 0.001);
    bodies.push_back(a);
    bodies.push_back(b);
  }
  std::uint64_t calls = 0;
  std::uint32_t work = 0;
  {
    const posix::HeapTrapScope scope;
    for (std::size_t i = 0; i + 1 < bodies.size(); i += 2) {
      work += query(bodies[i], bodies[i + 1]).support_calls;
      work += manifold(bodies[i], bodies[i + 1]).count + manifold(bodies[i], HalfSpace{}).count;
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(work > 200);
}

TEST_CASE("convex: on a nose that is not quite parallel, the run's face is never worse than its preference") {
  // A query prefers nothing and searches on: the twin of the manifold, which ends at a face that leads.
  Draw draw(31);
  const Convex step = at(make_box({0.14, 0.5, 0.085}), {0.14, 0, -0.085});
  int faces = 0;
  int missed = 0;
  double worst = -1.0;
  for (int i = 0; i < 4000; ++i) {
    Convex body = i % 2 == 0 ? kTrack : kFlipper;
    const double pitch = draw.within(-0.8, -0.3);
    const double size = i % 8 < 2 ? 1e-4 : i % 8 < 4 ? 1e-3 : i % 8 < 6 ? 1e-2 : 5e-2;
    const double roll = draw.within(-size, size);
    const double yaw = draw.within(-size, size);
    const RotationMatrix turn = to_matrix(from_yaw_pitch_roll(yaw, pitch, roll));
    const Vector3 under = turn * Vector3{-body.run_normal[0], 0.0, body.run_normal[1]};
    const Vector3 run = turn * Vector3{body.run_normal[1], 0.0, body.run_normal[0]};
    const double depth = draw.within(-2e-4, 4e-4);
    const double along = draw.within(-0.3, 1.3) * body.length_m;
    const Vector3 aside{0.0, draw.within(-0.3, 0.3), 0.0};
    place(body, {}, from_yaw_pitch_roll(yaw, pitch, roll));
    body.p_world_m = aside + (body.radius_m[0] - depth) * under - along * run;
    const Manifold found = manifold(body, step);
    const QueryResult least = query(body, step);
    if (found.count == 0) {
      if (least.depth_m >= 0.0) ++missed;
      continue;
    }
    const double overlap = overlap_by_parts(body, step, found.contacts[0].normal);
    worst = std::max(worst, overlap - least.depth_m);
    ++faces;
  }
  INFO("worse by " << worst);
  CHECK(faces > 2000);
  CHECK(missed == 0);
  CHECK(worst <= ManifoldOptions{}.face_preference_m + 1e-6);
}

}  // namespace sortie::rt::convex::test
