// SPDX-License-Identifier: BSD-3-Clause
// One random pair each, judged by rt/convex and by the oracle: shared by the quick test and the long one.
#pragma once

#include <catch2/catch.hpp>

#include "tests/rt/convex_oracle.hpp"

namespace sortie::rt::convex::test {

/// What must stay zero, and how often each state was said.
struct Verdicts {
  long states[4]{};
  long false_free{};       ///< "separated" without a gap along the normal that was given
  long false_collision{};  ///< a collision although the gap is wider than 0.1 mm
  long wrong_depth{};      ///< the depth is not the overlap along the normal; for boxes: not the smallest
  void require() const {
    CHECK(false_free == 0);
    CHECK(false_collision == 0);
    CHECK(wrong_depth == 0);
  }
};

/// A box beside a box: the separating axes by their corners.
inline void check_boxes(Draw& draw, Verdicts& verdicts) {
  Convex a = any_box(draw);
  Convex b = any_box(draw);
  a.R_world_body = to_matrix(draw.chance(0.8) ? draw.turn() : Quaternion{});
  b.R_world_body = to_matrix(draw.chance(0.8) ? draw.turn() : Quaternion{});
  const double apart = draw.within(0.0, 1.5);
  a.p_world_m = apart * draw.direction();
  double least = 1e300;
  const auto look = [&](const Vector3& axis) {
    const double length = norm(axis);
    if (length < 1e-6) return;
    const Vector3 d = (1.0 / length) * axis;
    least = std::min({least, overlap_by_parts(a, b, d), overlap_by_parts(a, b, -1.0 * d)});
  };
  for (int i = 0; i < 3; ++i) {
    look(column(a, i));
    look(column(b, i));
    for (int k = 0; k < 3; ++k) look(cross(column(a, i), column(b, k)));
  }
  const QueryResult q = query(a, b);
  ++verdicts.states[static_cast<int>(q.state)];
  const double along = overlap_by_parts(a, b, q.normal);
  if (std::fabs(along - q.depth_m) > 1e-9) ++verdicts.wrong_depth;
  if (q.state == State::separated) {
    if (along > -1e-10 || least > 1e-6) ++verdicts.false_free;
    return;
  }
  if (least < -1e-6) ++verdicts.false_collision;
  if (std::fabs(least - q.depth_m) > 1e-9) ++verdicts.wrong_depth;
}

/// A track beside a box: a gap is believed by the overlap along its normal, a collision by a point near both.
inline void check_track_and_box(Draw& draw, Verdicts& verdicts) {
  Convex a = any_track(draw);
  Convex b = any_box(draw);
  b.R_world_body = to_matrix(draw.turn());
  if (draw.chance(0.5)) {
    const double overlap = draw.within(-0.002, 0.002);
    put_shallow(draw, a, b, overlap);
  } else {
    a.R_world_body = to_matrix(draw.turn());
    const double apart = draw.within(0.0, 1.5);
    a.p_world_m = apart * draw.direction();
  }
  const bool swapped = draw.chance(0.5);
  const Convex& first = swapped ? b : a;
  const Convex& second = swapped ? a : b;
  const QueryResult q = query(first, second);
  ++verdicts.states[static_cast<int>(q.state)];
  const double along = overlap_by_parts(first, second, q.normal);
  if (std::fabs(along - q.depth_m) > 1e-9) ++verdicts.wrong_depth;
  if (q.state == State::separated) {
    if (along > -1e-10) ++verdicts.false_free;
    return;
  }
  // Projections creep between surfaces that graze each other; then the directions are tried.
  if (gap_from_above(a, b, 1e-4, 500, q.point_m) > 1e-4 && depth_by_search(a, b, 2000, 8) < -1e-4) {
    ++verdicts.false_collision;
  }
}

struct ShallowCount {
  long judged{};
  long wrong{};
  double worst_m{};
};

/// A track 0.1 to 5 mm deep in a box: the depth against the smallest one that a search finds.
inline void check_shallow(Draw& draw, ShallowCount& count) {
  Convex a = any_track(draw);
  Convex b = any_box(draw);
  b.R_world_body = to_matrix(draw.turn());
  const double overlap = draw.within(1e-4, 5e-3);
  put_shallow(draw, a, b, overlap);
  const QueryResult q = query(a, b);
  const double depth = depth_by_search(a, b, 600, 4);
  if (depth < 1e-4) return;
  ++count.judged;
  const double error = q.state == State::penetrating ? q.depth_m - depth : 1.0;
  count.worst_m = std::max(count.worst_m, error);
  if (error > 1e-3) ++count.wrong;
}

}  // namespace sortie::rt::convex::test
