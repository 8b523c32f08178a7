// SPDX-License-Identifier: BSD-3-Clause
// rt/convex: no false "free", no false "collision", depths, and what happens at the edges of its range.
#include "rt/convex/query.hpp"

#include <catch2/catch.hpp>
#include <cstdio>
#include <limits>

#include "rt/convex/portal.hpp"
#include "tests/rt/convex_checks.hpp"

namespace sortie::rt::convex::test {
namespace {

constexpr std::uint64_t kSeed = 20240611;

Convex turned(Convex body, const Vector3& p, const Vector3& phi) {
  place(body, p, exp_rotation(phi));
  return body;
}

}  // namespace

TEST_CASE("convex: boxes are judged as the exact separating axes judge them", "[heavy]") {
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  Draw draw(kSeed);
  Verdicts verdicts;
  for (int i = 0; i < 30000; ++i) check_boxes(draw, verdicts);
  verdicts.require();
  CHECK(verdicts.states[0] > 3000);
  CHECK(verdicts.states[2] > 3000);
}

TEST_CASE("convex: tracks and boxes: what is said is proved by an oracle of its own", "[heavy]") {
  Draw draw(kSeed + 1);
  Verdicts verdicts;
  for (int i = 0; i < 30000; ++i) check_track_and_box(draw, verdicts);
  verdicts.require();
  CHECK(verdicts.states[0] > 3000);
  CHECK(verdicts.states[2] > 3000);
  CHECK(verdicts.states[3] < 10);  // some near touches end on the budget; they count as collisions
}

TEST_CASE("convex: the depth of shallow contacts is the smallest one") {
  Draw draw(kSeed + 2);
  ShallowCount count;
  for (int i = 0; i < 400; ++i) check_shallow(draw, count);
  INFO("worst error " << count.worst_m);
  CHECK(count.judged > 350);
  CHECK(count.wrong == 0);
}

TEST_CASE("convex: one inside the other, the same middle, exact touch, large against small, far away") {
  const Convex small = make_box({0.1, 0.1, 0.1});
  const Convex track = make_track(0.089, 0.029, 0.33, 0.0249);
  const Convex large = make_box({5, 5, 5});
  for (const Convex& body : {small, track}) {
    CHECK(query(body, large).state == State::penetrating);
    CHECK(query(large, body).state == State::penetrating);
    CHECK(query(body, body).state == State::penetrating);
    CHECK(query(turned(body, {1, 2, 3}, {0.3, -0.2, 1.0}), large).state == State::penetrating);
  }
  const QueryResult deep = query(small, large);
  CHECK(deep.depth_m == Approx(5.1).margin(1e-12));
  // Kissing: no gap is proved and no overlap is claimed; a micrometre decides.
  const Convex on_top = turned(small, {0.3, 0.2, 5.1}, {});
  CHECK(is_collision(query(on_top, large).state));
  CHECK(std::fabs(query(on_top, large).depth_m) < 1e-9);
  CHECK(query(turned(small, {0.3, 0.2, 5.100001}, {}), large).state == State::separated);
  CHECK(query(turned(small, {0.3, 0.2, 5.099999}, {}), large).state == State::penetrating);
  Convex wheel = make_cylinder(0.25, 0.125);
  wheel.p_world_m = {0, 0, 5.25};  // binary fractions: it touches exactly
  const QueryResult kiss = query(wheel, large);
  CHECK(is_collision(kiss.state));
  CHECK(std::fabs(kiss.depth_m) < 1e-9);
  CHECK(kiss.normal.z == Approx(1.0));
  // Far from the world's origin only the rounding of the input is lost.
  for (const double far : {1e3, 1e6}) {
    Convex a = turned(track, {far, -far, 0.02899}, {});
    Convex b = turned(large, {far + 0.1, -far, -5.0}, {});
    a.p_world_m.z = 0.088;
    const QueryResult q = query(a, b);
    CHECK(q.state == State::penetrating);
    CHECK(q.depth_m == Approx(0.001).margin(1e-9));
    CHECK(std::fabs(q.point_m.x - far) < 6.0);
  }
  // A needle's tip against a hall, and the hall against it.
  const Convex needle = turned(make_track(1e-4, 1e-4, 0.5, 1e-4), {4.9, 0.3, 5.0004}, {0, 0.6, 0});
  CHECK(query(needle, make_box({500, 500, 5})).state == query(make_box({500, 500, 5}), needle).state);
}

TEST_CASE("convex: what is no body counts as a collision") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Convex box = make_box({1, 1, 1});
  CHECK(make_box({0, 1, 1}).kind == Kind::none);
  CHECK(make_box({1, kNan, 1}).kind == Kind::none);
  CHECK(make_track(0.1, 0.1, -1, 0.1).kind == Kind::none);
  CHECK(make_track(0.1, 0.1, kNan, 0.1).kind == Kind::none);
  CHECK(make_swept_ellipsoid({1, 1, -1}, {}).kind == Kind::none);
  CHECK(query(make_box({0, 1, 1}), box).state == State::unknown);
  Convex lost = box;
  lost.p_world_m.x = kNan;
  CHECK(query(lost, box).state == State::unknown);
  CHECK(query(box, lost).state == State::unknown);
  lost = box;
  lost.R_world_body.m[4] = std::numeric_limits<double>::infinity();
  CHECK(query(lost, box).state == State::unknown);
  CHECK(is_collision(State::unknown));
}

namespace {

// Runs away from every bound: each answer lies further out than all before, whatever was asked.
Vector3 lying_support(const void* body, const Vector3& direction) {
  double& far = *static_cast<double*>(const_cast<void*>(body));
  far *= 1.5;
  return far * (direction + Vector3{0.1 * far, -0.01 * far, 0.2});
}

}  // namespace

TEST_CASE("convex: a budget ends libccd's loops even for a support function that lies") {
  for (const std::uint32_t budget : {0u, 1u, 7u, 16u, 33u, 64u}) {
    double far_a = 1.0;
    double far_b = 1.0;
    const SupportBody a{&far_a, lying_support, {0.1, 0.2, 0.3}};
    const SupportBody b{&far_b, lying_support, {}};
    const PortalResult result = refine_portal(a, b, budget);
    CHECK(result.support_calls <= budget);
  }
  // An honest pair on a budget that is too small is unknown, never free.
  Draw draw(kSeed + 3);
  int unknown = 0;
  for (int i = 0; i < 3000; ++i) {
    const Convex b = any_box(draw);
    Convex a = any_track(draw);
    put_shallow(draw, a, b, 0.002);
    const auto calls = static_cast<std::uint32_t>(draw.below(12));
    const QueryResult q = query(a, b, {calls, calls});
    CHECK(is_collision(q.state));
    CHECK(q.support_calls <= calls);
    unknown += q.state == State::unknown ? 1 : 0;
  }
  CHECK(unknown > 300);
}

TEST_CASE("convex: support gives a point of the body for a zero direction and for a NaN") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Draw draw(kSeed + 4);
  for (int i = 0; i < 100; ++i) {
    Convex body = i % 3 == 0   ? make_swept_ellipsoid({0.35, 0.3, 0.15}, {0.2, 0.1, 0})
                  : i % 3 == 1 ? any_box(draw)
                               : any_track(draw);
    body.R_world_body = to_matrix(draw.turn());
    for (const Vector3& d : {Vector3{}, Vector3{kNan, 0, 0}, Vector3{kNan, kNan, kNan}, Vector3{1e-300, 0, 0},
                             Vector3{0, 1e300, 0}}) {
      const Vector3 p = support(body, d);
      REQUIRE(is_finite(p));
      CHECK(contains(body, middle(body) + (1.0 - 1e-9) * (p - middle(body))));
    }
  }
}

TEST_CASE("convex: an ellipsoid on its way is stopped by a wall and passes a window") {
  Convex flight = make_swept_ellipsoid({0.35, 0.35, 0.15}, {1.0, 0, 0});
  const Convex wall = turned(make_box({0.1, 2, 2}), {0.5, 0, 0}, {});
  CHECK(query(flight, wall).state == State::penetrating);
  for (const double height : {0.1501, 0.1499}) {  // the window's frame, above and below
    const Convex above = turned(make_box({0.1, 2, 1}), {0.5, 0, 1.0 + height}, {});
    const Convex below = turned(make_box({0.1, 2, 1}), {0.5, 0, -1.0 - height}, {});
    CHECK(is_collision(query(flight, above).state) == (height < 0.15));
    CHECK(is_collision(query(flight, below).state) == (height < 0.15));
  }
}

TEST_CASE("convex: bounds hold the body and touch it") {
  Draw draw(kSeed + 5);
  for (int i = 0; i < 200; ++i) {
    Convex body = i % 2 == 0 ? any_box(draw) : any_track(draw);
    const double x = draw.within(-9, 9);
    body.p_world_m = {x, -x, 2.0};
    body.R_world_body = to_matrix(draw.turn());
    const Bounds b = bounds(body);
    CHECK(b.high_m.x == Approx(reach_by_parts(body, {1, 0, 0})).margin(1e-12));
    CHECK(b.low_m.y == Approx(-reach_by_parts(body, {0, -1, 0})).margin(1e-12));
    CHECK(b.high_m.z == Approx(reach_by_parts(body, {0, 0, 1})).margin(1e-12));
    CHECK(overlap(b, b));
    CHECK_FALSE(overlap(b, {b.high_m + Vector3{0.1, 0, 0}, b.high_m + Vector3{1, 1, 1}}));
  }
}

}  // namespace sortie::rt::convex::test
