// SPDX-License-Identifier: BSD-3-Clause
// Curvature, phases and edges, the ideas that follow from them, and the tree that chooses.
#include "estimators/obstacle_modes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "estimators/obstacle_tree_table.hpp"

namespace sortie::estimators {
namespace {

static_assert(ends_within(kSideTree, kTreeDepth) && ends_within(kNameTree, kTreeDepth) &&
              std::all_of(std::begin(kPivotTrees), std::end(kPivotTrees),
                          [](const TreeNode* tree) { return ends_within(tree, kTreeDepth); }));

constexpr double kNoEdge = 1.0;
constexpr double kLongAgo_m = 1.0;
constexpr double kSlowWindows = 5.0;
constexpr double kLongWindows = 15.0;
constexpr double kFastest_rad_m = 20.0;  // of curvatures as features
constexpr double kEdgeApart_m = 0.05;    // nearer ones are one
constexpr double kEdgeBehind_m = 0.02;   // beyond a wheel's axle an edge is gone
constexpr double kClimbing_rad = 0.05;   // tilt from which a step is measured
constexpr double kChange = 0.2;          // of curvature, beyond which nothing is measured
constexpr double kWellUnder = 0.9;       // share of the run in which an edge is surely under it
constexpr double kTurning = 1.0;         // times the curvature that begins a rise: no plane
constexpr double kUnderCom_m = 0.1;      // an edge so near the balance point is the one to tip about

double tilt_of(double along, double a, double b) { return rt::atan2(along, std::sqrt(a * a + b * b)); }

double smooth(double old, double now, double way, double window) {
  return old + way / (way + window) * (now - old);
}

}  // namespace

ObstacleModes::ObstacleModes(const ObstacleModesConfig& config) : config_(config) {}

ObstacleMotion ObstacleModes::update(const ObstacleStep& step) {
  const double nose_up = -step.turn_rad.y;
  const double speed = step.travel_m / step.dt_s;
  if (std::fabs(speed) > config_.still_speed_m_s) direction_ = speed > 0.0 ? 1.0 : -1.0;
  const double way = std::fabs(step.travel_m) + config_.creep_m_s * step.dt_s;
  pitch_ = tilt_of(step.up_end.x, step.up_end.y, step.up_end.z);
  const double roll = tilt_of(step.up_end.y, step.up_end.z, 0.0);
  if (!started_) {
    started_ = true;
    reference_ = base_ = phase_pitch_ = pitch_;
    steady_ = 2.0 * config_.settled_m;  // it begins on a plane
    rise_ago_ = fall_ago_ = kLongAgo_m;
  }
  curvature_ = smooth(curvature_, nose_up / way, way, config_.window_m);
  slow_curvature_ = smooth(slow_curvature_, nose_up / way, way, kSlowWindows * config_.window_m);
  long_curvature_ = smooth(long_curvature_, nose_up / way, way, kLongWindows * config_.window_m);
  roll_curvature_ = smooth(roll_curvature_, step.turn_rad.x / way, way, config_.window_m);
  rate_ = nose_up / step.dt_s;
  const double level_rate = std::sqrt(step.turn_rad.x * step.turn_rad.x + nose_up * nose_up) / step.dt_s;
  still_ = std::fabs(speed) <= config_.still_speed_m_s && level_rate <= config_.still_rate_rad_s;
  follow_edges(step.travel_m);
  change_phase(std::fabs(step.travel_m));
  look(step, roll);

  ObstacleMotion motion;
  if (still_) {
    state_.mode = static_cast<std::uint32_t>(ObstacleMode::stationary);
    state_.confidence = 1.0;
    motion.step_body_m.x = step.travel_m;
    return motion;
  }
  const TreeNode& side = decide(kSideTree, features_);
  motion.step_body_m = {step.travel_m, 0.0, -step.turn_rad.x * side_of(static_cast<SideIdea>(side.what))};
  const double of_roll = static_cast<double>(side.sigma_m) * step.turn_rad.x;
  double of_pitch = kCalmSigma_m * nose_up;
  double of_way = 0.0;
  if (!settled()) {
    constexpr double share = 1.0 / static_cast<double>(std::size(kPivotTrees));
    of_pitch = 0.0;
    for (const TreeNode* tree : kPivotTrees) {
      const TreeNode& leaf = decide(tree, features_);
      const auto idea = static_cast<PivotIdea>(leaf.what);
      motion.step_body_m.z +=
          share * (idea == PivotIdea::fixed ? -nose_up * direction_ * static_cast<double>(leaf.value)
                                            : normal_of(idea));
      if (phase_ != Phase::calm && idea != PivotIdea::middle)
        motion.step_body_m.x += share * nose_up * config_.profile.run_m();
      of_pitch += share * static_cast<double>(leaf.sigma_m) * nose_up;
      of_way += share * static_cast<double>(leaf.sigma) * way;
    }
  }
  name_mode(std::fabs(step.travel_m));
  motion.sigma_m = std::sqrt(0.5 * (of_pitch * of_pitch + of_way * of_way) + of_roll * of_roll);
  return motion;
}

void ObstacleModes::follow_edges(double travel_m) {
  const double end = config_.profile.half_length_m + kEdgeBehind_m;
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < edge_count_; ++i) {
    const double x = edges_[i] - travel_m;
    if (std::fabs(x) <= end) edges_[kept++] = x;
  }
  edge_count_ = kept;
  balance_ -= travel_m;
}

void ObstacleModes::add_edge(double x_m) {
  for (std::uint32_t i = 0; i < edge_count_; ++i)
    if (std::fabs(edges_[i] - x_m) < kEdgeApart_m) return;
  if (edge_count_ == kEdges) {
    for (std::uint32_t i = 1; i < kEdges; ++i) edges_[i - 1] = edges_[i];
    --edge_count_;
  }
  edges_[edge_count_++] = x_m;
}

void ObstacleModes::enter(Phase phase) {
  if (phase_ == Phase::calm) steady_before_ = steady_;
  if (phase_ != Phase::calm) last_turn_ = direction_ * (pitch_ - phase_pitch_);
  phase_ = phase;
  if (phase == Phase::rise) rise_ago_ = 0.0;
  if (phase == Phase::fall) fall_ago_ = 0.0;
  phase_pitch_ = pitch_;
  phase_travel_ = 0.0;
  peak_ = 0.0;
  steady_ = 0.0;
  if (phase != Phase::fall) return;
  const double under = balance_on_run_m(config_.profile, pitch_);
  balance_ = under;
  for (std::uint32_t i = 0; i < edge_count_; ++i)
    if (std::fabs(edges_[i] - under) < kUnderCom_m) balance_ = edges_[i];
  add_edge(balance_);
}

/// Rises and falls of the leading end, by curvature: a threshold on the turn rate would depend on speed.
void ObstacleModes::change_phase(double travel_m) {
  const double lead = direction_ * curvature_;
  phase_travel_ += travel_m;
  away_ += travel_m;
  rise_ago_ += travel_m;
  fall_ago_ += travel_m;
  if (std::fabs(lead) < config_.leave_rad_m) {
    if (phase_ != Phase::calm) enter(Phase::calm);
    steady_ += travel_m;
    if (steady_ > config_.steady_m) reference_ = pitch_;
    if (steady_ > config_.settled_m) {
      base_ = pitch_;
      away_ = 0.0;
    }
    return;
  }
  if (lead > config_.enter_rad_m && phase_ != Phase::rise) enter(Phase::rise);
  if (lead < -config_.enter_rad_m && phase_ != Phase::fall) enter(Phase::fall);
  if (phase_ != Phase::rise) return;
  peak_ = std::max(peak_, lead);
  if (lead < config_.edge_share * peak_) {  // the leading wheel has come over the edge
    add_edge(direction_ * config_.profile.half_length_m);
    peak_ = 0.0;
  }
}

/// The edges under the robot that lie farthest ahead and behind, in the direction of its way.
ObstacleModes::EdgeSpan ObstacleModes::edge_span() const {
  EdgeSpan span{kNoEdge, kNoEdge};
  for (std::uint32_t i = 0; i < edge_count_; ++i) {
    const double x = direction_ * edges_[i];
    if (i == 0 || x > span.first) span.first = x;
    if (i == 0 || x < span.last) span.last = x;
  }
  return span;
}

void ObstacleModes::find_sides() {
  // By the smoothed rate: the sign of a single step would rectify its noise.
  const bool rolls_over = std::fabs(roll_curvature_) > config_.enter_rad_m;
  const double away = !rolls_over ? 0.0 : roll_curvature_ > 0.0 ? 1.0 : -1.0;
  sides_[0] = 0.0;
  sides_[1] = -away * config_.profile.half_width_m;  // the side that goes down stays: the other one climbs
  sides_[2] = away * config_.profile.half_width_m;
}

/// The height of the edge that it climbs, from where it turns about.
void ObstacleModes::measure_edge(const ObstacleStep& step, const Support& rear, double tilt) {
  if (phase_ != Phase::rise || !(direction_ * tilt > kClimbing_rad) || !(std::fabs(step.travel_m) > 0.0))
    return;
  // Per metre of belt alone: the height is not to shrink with the creep in the smoothed curvature. Where
  // the curvature changes, its smoothed value is none of the present.
  const double creep = 1.0 + config_.creep_m_s * step.dt_s / std::fabs(step.travel_m);
  const double steady = creep * (direction_ * curvature_);
  const bool changes = std::fabs(-step.turn_rad.y / step.travel_m - steady) > kChange * std::fabs(steady);
  const double under = pivot_on_run(rear, tilt, steady);
  if (!changes && std::fabs(under) < kWellUnder * config_.profile.half_length_m)
    state_.step_height_m = edge_height_m(config_.profile, rear, under, tilt);
}

void ObstacleModes::look(const ObstacleStep& step, double roll_rad) {
  const TrackProfile& p = config_.profile;
  const double nose_up = -step.turn_rad.y;
  const bool ahead = direction_ > 0.0;
  const double lead = direction_ * curvature_;
  const double tilt = pitch_ - reference_;
  const EdgeSpan span = edge_span();
  const Support rear = support_of(p, ahead ? OutlineEnd::rear : OutlineEnd::front, tilt, step.flippers);
  const Support front = support_of(p, ahead ? OutlineEnd::front : OutlineEnd::rear, tilt, step.flippers);
  const double rolls = pivot_on_run(rear, tilt, lead);
  const double front_rolls = pivot_on_run(front, tilt, lead);
  const double end = p.half_length_m;
  const double base_tilt = pitch_ - base_;
  const double slide = step.travel_m * rt::sincos(tilt).sin;
  const double base_slide = step.travel_m * rt::sincos(base_tilt).sin;
  const double values[kPivotIdeas] = {0.0,
                                      -nose_up * rear.x_m,
                                      -nose_up * std::clamp(rolls, -end, end),
                                      edge_count_ > 0 ? -nose_up * direction_ * span.first : 0.0,
                                      -nose_up * std::clamp(balance_, -end, end),
                                      -nose_up * front.x_m,
                                      -nose_up * std::clamp(front_rolls, -end, end),
                                      -nose_up * rear.x_m - slide,
                                      -nose_up * rear.x_m - base_slide,
                                      -nose_up * front.x_m - base_slide,
                                      0.0};
  std::copy(values, values + kPivotIdeas, normals_);
  find_sides();
  measure_edge(step, rear, tilt);
  const auto limited = [](double x, double most) { return std::clamp(x, -most, most); };
  const double turned = direction_ * (pitch_ - phase_pitch_);
  const double list[kModeFeatures] = {
      limited(lead, kFastest_rad_m),
      limited(direction_ * slow_curvature_, kFastest_rad_m),
      direction_ * tilt,
      direction_ * pitch_,
      turned,
      limited(phase_travel_, 1.0),
      peak_ > 0.0 ? lead / peak_ : 1.0,
      limited(steady_before_, 1.0),
      span.first,
      span.last,
      limited(direction_ * rolls, 1.0),
      direction_ * rate_,
      limited(roll_rad > 0.0 ? roll_curvature_ : -roll_curvature_, kFastest_rad_m),
      std::fabs(roll_rad),
      ahead ? step.flippers.front_rad : step.flippers.rear_rad,
      ahead ? step.flippers.rear_rad : step.flippers.front_rad,
      direction_ * base_tilt,
      limited(steady_, 1.0),
      limited(away_, 2.0),
      limited(rise_ago_, kLongAgo_m),
      limited(fall_ago_, kLongAgo_m),
      last_turn_,
      limited(direction_ * long_curvature_, kFastest_rad_m)};
  std::copy(list, list + kModeFeatures, features_);
}

/// The name is for people; the motion does not follow from it. It changes when the tree has said another one
/// for a while, counted in travel; a settled robot is on a plane at once.
void ObstacleModes::name_mode(double travel_m) {
  std::uint32_t name = static_cast<std::uint32_t>(ObstacleMode::planar);
  double sure = 1.0;
  if (!settled()) {
    const TreeNode& leaf = decide(kNameTree, features_);
    name = leaf.what;
    sure = static_cast<double>(leaf.sigma);
    if (direction_ < 0.0 && name == static_cast<std::uint32_t>(ObstacleMode::low_rear)) {
      name = static_cast<std::uint32_t>(ObstacleMode::low_front);
    } else if (direction_ < 0.0 && name == static_cast<std::uint32_t>(ObstacleMode::low_front)) {
      name = static_cast<std::uint32_t>(ObstacleMode::low_rear);
    }
  }
  // A body that turns so fast is on no plane; what the tree is unsure of stays what it was.
  const bool turns = phase_ != Phase::calm && std::fabs(curvature_) > kTurning * config_.enter_rad_m;
  if (turns && name == static_cast<std::uint32_t>(ObstacleMode::planar)) name = state_.mode;
  other_name_m_ = name == state_.mode ? 0.0 : other_name_m_ + travel_m;
  const bool stood = state_.mode == static_cast<std::uint32_t>(ObstacleMode::stationary);
  if (other_name_m_ > config_.name_m || stood || settled()) {
    state_.mode = name;
    other_name_m_ = 0.0;
  }
  state_.confidence = name == state_.mode ? sure : 1.0 - sure;
}

void ObstacleModes::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "obstacle modes")
      .fixed(config_)
      .state(curvature_, slow_curvature_, long_curvature_, roll_curvature_, rate_, pitch_, reference_, base_,
             phase_pitch_)
      .state(phase_travel_, steady_before_, steady_, peak_, balance_, edges_, direction_, phase_)
      .state(away_, rise_ago_, fall_ago_, last_turn_, other_name_m_)
      .state(started_, still_, features_, normals_, sides_, state_)
      .by_hand(edge_count_);
  archive.bounded(edge_count_, kEdges);
}

}  // namespace sortie::estimators
