// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/pair.hpp"

#include <algorithm>
#include <cmath>

#include "rt/convex/descent.hpp"
#include "rt/convex/local.hpp"
#include "rt/convex/nearest.hpp"
#include "rt/convex/portal.hpp"
#include "rt/convex/support.hpp"

namespace sortie::rt::convex {
namespace {

constexpr double kSettled_m = 1e-7;  // facing points this near to the overlap: no direction beside is better
constexpr double kProven_m = 1e-4;   // what proven() may overlook
constexpr double kDoubt_m = 1e-7;    // what two searches may differ by
constexpr std::uint32_t kPointCalls = 48;  // a contact of two points is worth these beyond the budget

Vector3 support_of(const void* body, const Vector3& direction) {
  return support(*static_cast<const Convex*>(body), direction);
}

class Judge {
 public:
  Judge(const Convex& a, const Convex& b, double margin_m, double face_preference_m, const Budget& budget)
      : a_(a),
        b_(b),
        margin_m_(margin_m),
        search_(a_, b_, margin_m, face_preference_m),
        left_(budget.support_calls),
        polish_left_(budget.polish_calls) {
    a_.p_world_m = a.p_world_m - b.p_world_m;  // digits stay where the bodies are, wherever that is
    b_.p_world_m = {};
    preference_m_ = face_preference_m;
    clearance_m_ = std::max(1e-6, 0.02 * std::min(thickness(a_), thickness(b_)));
  }

  PairJudgement run() {
    if (search_.consider_all()) return apart();
    out_.axis = search_.best();
    look();
    const bool settled = is_settled();
    if (settled && (exact() || proven())) return done();
    const bool overlap = out_.axis.overlap_m >= -kTouching_m;
    if (overlap && !exact() && !ask_portal()) return apart();
    if (out_.axis.overlap_m < -kTouching_m) {
      if (!adopt(nearest_direction(a_, b_, out_.axis.direction, polish_left_))) return apart();
    } else {
      if ((!settled || improved_by_portal_) && !improve(out_.axis.direction)) return apart();
      if (!exact() && !improve_rims()) return apart();
    }
    out_.axis = search_.best();
    look();
    return point_contact() ? done() : apart();
  }

 private:
  PairJudgement apart() {
    out_.state = State::separated;
    out_.axis = search_.best();
    out_.points.count = 0;
    return out_;
  }

  void look() {
    const Vector3& d = out_.axis.direction;
    out_.points = overlay(feature(a_, -1.0 * d), feature(b_, d), d);
    deepest_m_ = -1e300;
    for (std::uint32_t i = 0; i < out_.points.count; ++i) {
      double& depth = out_.points.points[i].depth_m;
      depth = std::min(depth, out_.axis.overlap_m);
      deepest_m_ = std::max(deepest_m_, depth);
    }
  }

  bool exact() const { return a_.kind == Kind::box && b_.kind == Kind::box; }

  // The outermost points face each other: the direction is a smallest one among those beside it. So it is,
  // too, when they miss that by less than what a face is preferred by: the points that do face each other
  // leave no other direction so little overlap. (An edge that is longer than the face is wide, and not quite
  // in its plane, sticks out beside it. Features are drawn up to 0.1 of the preference too large: hence 0.8.)
  // An overlap is believed when a point is shown that lies in both bodies.
  bool is_settled() {
    const double lead_m = 0.8 * search_.lead_m(preference_m_);
    if (deepest_m_ < out_.axis.overlap_m - std::max(kSettled_m, lead_m)) return false;
    if (out_.axis.overlap_m < -kTouching_m) return true;
    Vector3 sum{};
    double depth = 0.0;
    double count = 0.0;
    for (std::uint32_t i = 0; i < out_.points.count; ++i) {
      if (out_.points.points[i].depth_m <= 0.0) continue;
      sum = sum + out_.points.points[i].point_m;
      depth += out_.points.points[i].depth_m;
      count += 1.0;
    }
    if (count == 0.0) return false;
    shared_m_ = (1.0 / count) * sum;
    shared_depth_m_ = depth / count;
    return contains(a_, shared_m_) && contains(b_, shared_m_);
  }

  // No other direction is better. A gap: the nearest points are known. An overlap by h along a face's normal
  // at a point that lies r inside the face's outline: in a direction at an angle t to the normal the overlap
  // is at least h cos t + r sin t, since the body reaches out by r there; that is no less than h up to a
  // right angle when r >= h, and beyond, the bodies' thickness speaks.
  bool proven() const {
    const double overlap = out_.axis.overlap_m;
    if (overlap < -kTouching_m) return true;
    if (0.5 * std::min(thickness(a_), thickness(b_)) < overlap) return false;
    const Overlay& points = out_.points;
    return points.inset_deepest_m >= overlap ||
           (points.inset_middle_m >= overlap && points.middle_depth_m >= overlap - kProven_m) ||
           proven_by_wheel(a_) || proven_by_wheel(b_);
  }

  // The same for a wheel's line: it reaches out by the radius, and along the axis by what is left of it.
  bool proven_by_wheel(const Convex& track) const {
    const double overlap = out_.axis.overlap_m;
    return track.kind == Kind::track && shared_depth_m_ >= overlap - kProven_m &&
           std::fabs(dot(axis_of(track, 1), out_.axis.direction)) <= 0.01 &&
           std::fabs(dot(axis_of(track, 1), shared_m_ - track.p_world_m)) <= track.half_m.y - overlap;
  }

  // False when a gap wider than the margin was proved.
  bool ask_portal() {
    const Vector3 middle_a = middle(a_);
    const SupportBody a{&a_, support_of, inside_near(a_, middle(b_))};
    const SupportBody b{&b_, support_of, inside_near(b_, middle_a)};
    const PortalResult portal = refine_portal(a, b, left_);
    spend(portal.support_calls);
    exhausted_ = portal.state == PortalState::exhausted;
    Vector3 direction;
    if (normalise(portal.last_direction, direction) && search_.consider(direction, preference_m_))
      return false;
    if (normalise(portal.depth_direction, direction) && search_.consider(direction, preference_m_))
      return false;
    improved_by_portal_ = search_.best().overlap_m < out_.axis.overlap_m;
    out_.axis = search_.best();
    if (portal.state != PortalState::apart || out_.axis.overlap_m < -kTouching_m) return true;
    // It says "apart" within its tolerance and has no proof: look for one.
    Simplex simplex;
    const NearestResult nearest = nearest_points(a_, {}, b_, out_.axis.direction, left_, simplex);
    spend(nearest.support_calls);
    if (left_ < 2) exhausted_ = true;
    if (nearest.apart && search_.consider(nearest.direction, 0.0)) return false;
    out_.axis = search_.best();
    return true;
  }

  bool improve(const Vector3& start) { return adopt(descend(a_, b_, start, clearance_m_, polish_left_)); }

  // Of both: false when a gap wider than the margin was proved.
  bool adopt(const Descent& descent) {
    if (!descent.found) return true;
    if (search_.consider(descent.axis.direction, preference_m_)) return false;
    if (!nearest_.found || descent.axis.overlap_m < nearest_.axis.overlap_m) nearest_ = descent;
    return true;
  }

  // A flat end of a track that is turned until an edge of the box lies along it: where the round rim of that
  // end presses on the edge, the smallest overlap is near there and far from every face.
  bool improve_rims() {
    const Convex& track = a_.kind == Kind::track ? a_ : b_;
    const Convex& other = a_.kind == Kind::track ? b_ : a_;
    if (track.kind != Kind::track) return true;
    Axis best[2];
    const Vector3 y = axis_of(track, 1);
    for (int i = 0; i < 3; ++i) {
      const Vector3 e = axis_of(other, i);
      Vector3 d;
      if (!normalise(y - dot(y, e) * e, d)) continue;
      for (int side = 0; side < 2; ++side) {
        const double overlap = overlap_along(a_, b_, d);
        if (overlap < best[0].overlap_m) {
          best[1] = best[0];
          best[0] = {d, overlap};
        } else if (overlap < best[1].overlap_m) {
          best[1] = {d, overlap};
        }
        d = -1.0 * d;
      }
    }
    for (const Axis& start : best) {
      if (start.overlap_m < 1e299 && !improve(start.direction)) return false;
    }
    return true;
  }

  PairJudgement done() {
    if (out_.axis.overlap_m < -kTouching_m) {
      out_.state = State::separated;
    } else if (exhausted_) {
      out_.state = State::unknown;
    } else {
      out_.state = out_.axis.overlap_m > kTouching_m ? State::penetrating : State::touching;
    }
    return out_;
  }

  // No features face each other along the best direction (a rim on an edge, a corner beside a corner): the
  // nearest points are the contact, with their own direction. False when their gap is wider than the margin.
  bool point_contact() {
    if (deepest_m_ >= -margin_m_) return true;
    if (!nearest_.found || nearest_.axis.overlap_m > out_.axis.overlap_m + preference_m_ + kDoubt_m) {
      polish_left_ = std::max(polish_left_, kPointCalls);
      nearest_ = descend(a_, b_, out_.axis.direction, clearance_m_, polish_left_);
    }
    const Vector3& d = out_.axis.direction;
    if (nearest_.found) {
      out_.axis = nearest_.axis;
    } else {  // where rounding or the budget left nothing better
      nearest_.point_m = 0.5 * (support(a_, -1.0 * d) + support(b_, d));
    }
    out_.points.count = 1;
    out_.points.points[0] = {nearest_.point_m, out_.axis.overlap_m, 0xffffffffu};
    return out_.axis.overlap_m >= -margin_m_;
  }

  void spend(std::uint32_t calls) {
    left_ -= std::min(left_, calls);
    out_.support_calls += calls;
  }

  Convex a_;
  Convex b_;
  double margin_m_;
  double preference_m_{};
  AxisSearch search_;
  std::uint32_t left_;
  std::uint32_t polish_left_;
  double clearance_m_{};
  bool exhausted_{};
  bool improved_by_portal_{};
  double deepest_m_{-1e300};
  double shared_depth_m_{};
  Vector3 shared_m_{};
  Descent nearest_{};
  PairJudgement out_{};
};

}  // namespace

PairJudgement judge_pair(const Convex& a, const Convex& b, double margin_m, double face_preference_m,
                         const Budget& budget) {
  return Judge(a, b, margin_m, face_preference_m, budget).run();
}

}  // namespace sortie::rt::convex
