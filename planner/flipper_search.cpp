// SPDX-License-Identifier: BSD-3-Clause
#include "planner/flipper_search.hpp"

#include <algorithm>
#include <cmath>

#include "planner/face_ahead.hpp"

namespace sortie::planner {
namespace {

constexpr double kAround_m =
    1.5;  // the farthest place, the vehicle's reach there, and that of a missing cell
constexpr double kUnsafeRank = 1000;  // a place: more than any cost
constexpr double kLeftRank = 1e6;     // of a candidate that was not judged to its end
constexpr int kCoarseStep = 2;        // steps of the fine grid between two angles of the coarse one
// From each place on: what is near is not safe, what is far leaves time to change.
constexpr double kFaceAhead_m[kArcPlaces] = {0.1, 0.05, 0.2, 0.1};
constexpr double kNudge_rad = 0.2;  // moves the centre of mass by about the least margin
constexpr double kSameRest_rad = 0.03;
constexpr double kMostStart_rad = 1.19;
constexpr int kMostFineRounds = 4;  // of eight neighbours each

bool usable_weights(const FlipperWeights& w) {
  for (const double price : {w.jump, w.swing, w.pitch, w.roll, w.clearance, w.margin, w.face, w.time,
                             w.change, w.wanted_clearance_m, w.wanted_margin_m})
    if (!(price >= 0.0 && price < 1e3)) return false;
  return true;
}

Status check(const FlipperSearchConfig& c) {
  const bool good = c.low_rad >= -1.6 && c.low_rad < c.high_rad && c.high_rad <= 3.2 && c.apart_m > 0.0 &&
                    c.apart_rad > 0.0 && c.apart_rad < 1.6 && c.rate_rad_s > 1e-3 && c.rate_rad_s < 100.0 &&
                    c.units >= FlipperSearch::kLeastUnits && c.units <= 10000 && c.most_tried >= 1 &&
                    c.most_tried <= 200 && c.limit >= 0.0 && c.limit < 1.0 && c.limits.margin_m >= 0.0 &&
                    c.limits.margin_m < 1.0 && c.limits.clearance_m >= 0.0 && c.limits.clearance_m < 1.0 &&
                    c.limits.tilt_rad > 0.0 && c.limits.tilt_rad < 1.6 && c.limits.jump_rad > 0.0 &&
                    c.limits.jump_rad < 3.2 && c.limits.climb_rad > 0.0 && c.limits.climb_rad < 1.57 &&
                    c.missing.reach_m > 0.0 && c.missing.reach_m <= 0.35 && c.missing.slope >= 0.0 &&
                    c.missing.slope < 10.0 && c.missing.hole_m >= 0.0 && c.missing.hole_m < 10.0;
  return good && usable_weights(c.weights) ? Status::ok : Status::out_of_range;
}

}  // namespace

FlipperSearch::FlipperSearch(const PostureVehicle& vehicle, const FlipperSearchConfig& config)
    : config_(config),
      middle_{PostureSolver(vehicle, config.posture), PostureSolver(vehicle, config.posture),
              PostureSolver(vehicle, config.posture), PostureSolver(vehicle, config.posture)},
      other_(vehicle, config.posture),
      usable_(other_.usable() == Status::ok ? check(config) : other_.usable()) {}

FlipperSearch::Candidate FlipperSearch::candidate_of(FlipperSet angles) const {
  Candidate candidate;
  double way[rt::kFlippers];
  double change[rt::kFlippers];
  for (std::uint32_t f = 0; f < rt::kFlippers; ++f) {
    double& angle = angles.angle_rad[f];
    if ((question_.broken >> f & 1u) != 0) angle = question_.measured_rad[f];
    way[f] = std::fabs(angle - question_.measured_rad[f]);
    change[f] = std::fabs(angle - question_.before.angle_rad[f]);
  }
  candidate.angles = angles;
  candidate.walk.tilt = question_.tilt;
  // Left and right are added first: so is it in the mirror image.
  candidate.fixed_cost =
      config_.weights.time * std::max({way[0], way[1], way[2], way[3]}) / config_.rate_rad_s +
      config_.weights.change * 0.25 * ((change[0] + change[1]) + (change[2] + change[3]));
  return candidate;
}

Posture FlipperSearch::rest_at(PostureSolver& solver, int place, Candidate& candidate) {
  Posture posture;
  FlipperWalk& walk = candidate.walk;
  ++units_;
  if (solver.rest(candidate.angles, walk.tilt, posture) != Status::ok) posture = {};
  bool blocked = false;
  if (posture.rest == Rest::stands) {
    const double direction = question_.arc.speed_m_s < 0.0 ? -1.0 : 1.0;
    blocked = question_.arc.speed_m_s != 0.0 && is_face_ahead(solver, candidate.angles, posture, direction,
                                                              kFaceAhead_m[place], config_.limits.climb_rad);
    if (posture.margin_m < config_.limits.margin_m) rock(solver, candidate.angles, posture);
  }
  walk.add(posture, blocked, config_.limits);
  return posture;
}

void FlipperSearch::rock(PostureSolver& solver, const FlipperSet& angles, Posture& posture) {
  // On the edge of a tread every vehicle with tracks has no margin for a moment. What counts is where it
  // goes: to a rest near by, or over.
  double margin = 1.0;
  bool other = false;
  for (const double nudge : {kNudge_rad, -kNudge_rad}) {
    const double pitch = std::clamp(posture.pitch_rad + nudge, -kMostStart_rad, kMostStart_rad);
    const double roll = std::clamp(posture.roll_rad, -kMostStart_rad, kMostStart_rad);
    Posture there;
    ++units_;
    if (solver.rest(angles, {pitch, roll}, there) != Status::ok || there.rest != Rest::stands) return;
    const double way = std::fabs(there.pitch_rad - posture.pitch_rad);
    if (way < kSameRest_rad) continue;
    if (std::max(way, std::fabs(there.roll_rad - posture.roll_rad)) > config_.limits.jump_rad) return;
    margin = std::min(margin, there.margin_m);
    other = true;
  }
  if (other) posture.margin_m = std::max(posture.margin_m, margin);
}

double FlipperSearch::try_angles(const FlipperSet& angles) {
  if (tried_ >= config_.most_tried || units_ + kArcPlaces * kRestUnits + reserve_ > config_.units)
    return kLeftRank;
  Candidate candidate = candidate_of(angles);
  for (const Candidate& kept : kept_) {
    if (std::equal(std::begin(kept.angles.angle_rad), std::end(kept.angles.angle_rad),
                   std::begin(candidate.angles.angle_rad)))
      return kept.rank;
  }
  ++tried_;
  const bool full = kept_.size() == kKept;
  for (int place = 0; place <= kArcPlaces; ++place) {
    candidate.rank =
        candidate.fixed_cost + candidate.walk.cost(config_.weights) + kUnsafeRank * candidate.walk.unsafe;
    if (full && candidate.rank >= kept_.back().rank) return kLeftRank;
    if (place < kArcPlaces) (void)rest_at(middle_[static_cast<std::size_t>(place)], place, candidate);
  }
  if (full) kept_.pop_back();
  (void)kept_.push_back(candidate);
  for (std::uint32_t k = kept_.size() - 1; k > 0 && kept_[k].rank < kept_[k - 1].rank; --k)
    std::swap(kept_[k], kept_[k - 1]);
  return candidate.rank;
}

void FlipperSearch::try_grid(int front, int rear) {
  if (front < 0 || rear < 0 || front >= kFine || rear >= kFine) return;
  bool& tried = grid_tried_[static_cast<std::size_t>(front * kFine + rear)];
  if (tried) return;
  tried = true;
  const double f = fine_angle(front);
  const double r = fine_angle(rear);
  const double rank = try_angles({{f, f, r, r}});
  if (rank >= best_rank_) return;
  best_rank_ = rank;
  best_front_ = front;
  best_rear_ = rear;
}

void FlipperSearch::try_grids() {
  grid_tried_ = {};
  best_rank_ = kLeftRank;
  best_front_ = best_rear_ = kFine / 2;
  for (int front = 0; front < kFine; front += kCoarseStep)
    for (int rear = 0; rear < kFine; rear += kCoarseStep) try_grid(front, rear);
  for (int round = 0; round < kMostFineRounds; ++round) {
    const int front = best_front_;
    const int rear = best_rear_;
    for (int k = -1; k <= 1; ++k)
      for (int l = -1; l <= 1; ++l) try_grid(front + k, rear + l);
    if (front == best_front_ && rear == best_rear_) break;
  }
}

int FlipperSearch::higher_side() const {
  const PostureVehicle& v = other_.vehicle();
  double higher = 0.0;
  bool apart = false;
  for (const PostureSolver& solver : middle_) {
    const GroundPatch& ground = solver.ground();
    PostureSolver::Looked as;
    if (solver.looked({}, as) != Status::ok) continue;
    const double side = as.mirrored ? -1.0 : 1.0;
    for (const double y : {v.side.half_width_m, v.flipper_y_m}) {
      const auto row = static_cast<int>(y / ground.spacing_m() + 0.5);
      const auto reach =
          static_cast<int>((v.side.pivot_x_m + v.side.flipper_m + v.side.tip_radius_m) / ground.spacing_m());
      for (int column = -reach; column <= reach; ++column) {
        const auto left = static_cast<double>(ground.height(column, row));
        const auto right = static_cast<double>(ground.height(column, -row));
        const auto unknown = static_cast<double>(0.5F * GroundPatch::kUnknown);
        if (left < unknown || right < unknown) continue;
        apart = apart || std::fabs(left - right) > config_.apart_m;
        higher += side * (left - right);
      }
    }
  }
  if (!apart) return 0;
  return higher < 0.0 ? -1 : 1;
}

void FlipperSearch::try_apart() {
  const int side = higher_side();
  if (side == 0) return;
  const FlipperSet middle = kept_[0].angles;
  // The flippers on the higher side first, so that a mirrored world has the mirrored order.
  const int high = side > 0 ? 0 : 1;
  for (const double up : {config_.apart_rad, -config_.apart_rad}) {
    for (const int axles : {1, 2, 3}) {
      FlipperSet angles = middle;
      for (int axle = 0; axle < 2; ++axle) {
        if ((axles >> axle & 1) == 0) continue;
        double& on_high = angles.angle_rad[2 * axle + high];
        double& on_low = angles.angle_rad[2 * axle + 1 - high];
        on_high = std::clamp(on_high + up, config_.low_rad, config_.high_rad);
        on_low = std::clamp(on_low - up, config_.low_rad, config_.high_rad);
      }
      (void)try_angles(angles);
    }
  }
}

Status FlipperSearch::search(const HeightView& view, const FlipperQuestion& question, FlipperFound& found) {
  if (usable_ != Status::ok) return usable_;
  const double ahead = question.arc.speed_m_s < 0.0 ? -1.0 : 1.0;
  const Status taken = ground_.take(view, question.pose, ahead, kAround_m, config_.missing);
  if (taken != Status::ok) return taken;
  found = {};
  question_ = question;
  kept_.clear();
  near_.clear();
  units_ = tried_ = 0;
  for (int k = 0; k < kArcPlaces; ++k) places_[k] = arc_place(question.pose, question.arc, kArcAhead_m[k]);
  const PostureVehicle& v = other_.vehicle();
  const double half_length = v.side.pivot_x_m + v.side.flipper_m + v.side.tip_radius_m;
  const double half_width = v.flipper_y_m + 0.5 * v.flipper_width_m;
  ground_.under({places_, 2}, half_length, half_width, found.under);
  near_open_ = found.under.open > 0;
  ground_.under(places_, half_length, half_width, found.under);
  open_ = found.under.open > 0;
  points_ = found.under.missing > 0 ? MissingGround::kPoints : 1;
  reserve_ = points_ > 1 ? kOtherUnits : 0;
  for (int k = 0; k < kArcPlaces; ++k) {
    units_ += kLookUnits;
    const Status looked = middle_[static_cast<std::size_t>(k)].look(ground_.view(0), places_[k]);
    if (looked != Status::ok) return looked;
  }
  FlipperSet stay;
  std::copy(std::begin(question.measured_rad), std::end(question.measured_rad), stay.angle_rad);
  for (const FlipperSet& angles : {stay, question.feel}) {
    Candidate candidate = candidate_of(angles);
    for (int place = 0; place < 2; ++place) {
      const Posture here = rest_at(middle_[static_cast<std::size_t>(place)], place, candidate);
      if (place > 0 || near_.size() > 0) continue;
      found.stay_stands = here.rest == Rest::stands;
      found.stay_height_m = here.height_m;
    }
    (void)near_.push_back(candidate);
  }
  (void)try_angles(question.before);
  try_grids();
  try_apart();
  judge_kept(found);
  found.tried = tried_;
  found.units = units_;
  return Status::ok;
}

}  // namespace sortie::planner
