// SPDX-License-Identifier: BSD-3-Clause
// What a choice of flippers costs, place by place without any pruning, and the best of the whole fine grid.
// Shares PostureSolver and is_face_ahead() with the search, nothing else. For ground of which nothing is
// missing.
#pragma once

#include "planner/face_ahead.hpp"
#include "tests/planner/flipper_rig.hpp"

namespace sortie::planner {

struct TwinJudgement {
  double cost{};
  bool safe{true};
};

/// Looks once at each place, then judges any choice.
class FlipperTwin {
 public:
  FlipperTwin(const FlipperSearchConfig& config, const HeightView& view, const FlipperQuestion& question)
      : config_(config), question_(question) {
    for (const double ahead : {0.0, 0.1, 0.25, 0.45}) {
      // An arc in 1,000 small steps.
      const double seconds =
          ahead / (std::fabs(question.arc.speed_m_s) + 0.3 * std::fabs(question.arc.turn_rad_s));
      StandPose at = question.pose;
      for (int k = 0; k < 1000; ++k) {
        const double half = at.yaw_rad + 0.5 * question.arc.turn_rad_s * seconds / 1000;
        at.x_m += question.arc.speed_m_s * seconds / 1000 * std::cos(half);
        at.y_m += question.arc.speed_m_s * seconds / 1000 * std::sin(half);
        at.yaw_rad += question.arc.turn_rad_s * seconds / 1000;
      }
      solvers_.push_back(std::make_unique<PostureSolver>(posture_vehicle({}), config.posture));
      must(solvers_.back()->look(view, at));
    }
  }

  TwinJudgement judge(const FlipperSet& f) {
    const FlipperLimits& l = config_.limits;
    const FlipperWeights& w = config_.weights;
    TwinJudgement out;
    double pitch = question_.tilt.pitch_rad, roll = question_.tilt.roll_rad;
    double jump = 0, swing = 0, worst_pitch = 0, worst_roll = 0, clearance = 1, margin = 1, faces = 0;
    const double face_ahead[] = {0.1, 0.05, 0.2, 0.1};
    for (std::size_t k = 0; k < solvers_.size(); ++k) {
      Posture p;
      must(solvers_[k]->rest(f, {pitch, roll}, p));
      if (p.rest != Rest::stands) {
        out.safe = false;
        margin = 0;
        continue;
      }
      const bool face =
          question_.arc.speed_m_s != 0.0 &&
          is_face_ahead(*solvers_[k], f, p, question_.arc.speed_m_s < 0 ? -1 : 1, face_ahead[k], l.climb_rad);
      faces += face ? 1 : 0;
      double m = p.margin_m;
      if (m < l.margin_m) {  // it may rock onto something better
        Posture a, b;
        must(solvers_[k]->rest(f, {std::min(1.19, p.pitch_rad + 0.2), std::clamp(p.roll_rad, -1.19, 1.19)},
                               a));
        must(solvers_[k]->rest(f, {std::max(-1.19, p.pitch_rad - 0.2), std::clamp(p.roll_rad, -1.19, 1.19)},
                               b));
        const auto same = [&](const Posture& q) { return std::fabs(q.pitch_rad - p.pitch_rad) < 0.03; };
        const auto near = [&](const Posture& q) {
          return q.rest == Rest::stands && (same(q) || (std::fabs(q.pitch_rad - p.pitch_rad) <= l.jump_rad &&
                                                        std::fabs(q.roll_rad - p.roll_rad) <= l.jump_rad));
        };
        if (near(a) && near(b) && !(same(a) && same(b)))
          m = std::max(m, std::min(same(a) ? 1.0 : a.margin_m, same(b) ? 1.0 : b.margin_m));
      }
      const double change = std::fabs(p.pitch_rad - pitch);
      if (m < l.margin_m || p.clearance_m < l.clearance_m || (face && k < 2) ||
          std::fabs(p.pitch_rad) > l.tilt_rad || std::fabs(p.roll_rad) > l.tilt_rad || change > l.jump_rad ||
          std::fabs(p.roll_rad - roll) > l.jump_rad)
        out.safe = false;
      jump = std::max(jump, change);
      swing += change;
      worst_pitch = std::max(worst_pitch, std::fabs(p.pitch_rad));
      worst_roll = std::max(worst_roll, std::fabs(p.roll_rad));
      clearance = std::min(clearance, p.clearance_m);
      margin = std::min(margin, m);
      pitch = p.pitch_rad;
      roll = p.roll_rad;
    }
    double longest = 0, changed = 0;
    for (int k = 0; k < 4; ++k) {
      longest = std::max(longest, std::fabs(f.angle_rad[k] - question_.measured_rad[k]));
      changed += 0.25 * std::fabs(f.angle_rad[k] - question_.before.angle_rad[k]);
    }
    out.cost = w.jump * jump + w.swing * swing + w.pitch * worst_pitch + w.roll * worst_roll +
               w.face * faces + w.clearance * std::max(0.0, w.wanted_clearance_m - clearance) +
               w.margin * std::max(0.0, w.wanted_margin_m - margin) + w.time * longest / config_.rate_rad_s +
               w.change * changed;
    return out;
  }

  /// The cheapest safe pair of the 13 x 13 grid; safe is false where there is none.
  TwinJudgement best_of_grid() {
    TwinJudgement best{1e9, false};
    for (int front = 0; front < 13; ++front)
      for (int rear = 0; rear < 13; ++rear) {
        const double a = config_.low_rad + (config_.high_rad - config_.low_rad) * front / 12;
        const double b = config_.low_rad + (config_.high_rad - config_.low_rad) * rear / 12;
        const TwinJudgement one = judge({{a, a, b, b}});
        if (one.safe && one.cost < best.cost) best = one;
      }
    return best;
  }

 private:
  static void must(Status status) {
    if (status != Status::ok) throw std::runtime_error("flippers: the twin has no answer");
  }

  FlipperSearchConfig config_;
  FlipperQuestion question_;
  std::vector<std::unique_ptr<PostureSolver>> solvers_;
};

/// A question on a drawn course: a place before or on it where the vehicle stands, and what it drives.
struct DrawnQuestion {
  CellGround ground;
  FlipperQuestion question;
  bool stands{};
};

inline DrawnQuestion drawn_question(std::uint64_t seed) {
  hil::Random random(seed, 0x71756573);
  DrawnQuestion drawn;
  drawn.ground = CellGround::of(random_course(kCourseFamilies[seed % 5], random));
  FlipperInput in =
      flipper_input(1, {random.uniform(-1.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(-0.5, 0.5)}, 0);
  for (int k = 0; k < 4; k += 2) in.measured_rad[k] = in.measured_rad[k + 1] = random.uniform(-0.4, 1.0);
  drawn.stands = settle(drawn.ground.view(), in);
  FlipperQuestion& q = drawn.question;
  q.pose = in.pose;
  q.arc = {random.uniform(0.1, 0.3), random.uniform(-0.2, 0.2)};
  q.tilt = {in.pitch_rad, in.roll_rad};
  for (int k = 0; k < 4; ++k)
    q.measured_rad[k] = q.before.angle_rad[k] = q.feel.angle_rad[k] = in.measured_rad[k];
  return drawn;
}

}  // namespace sortie::planner
