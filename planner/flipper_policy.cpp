// SPDX-License-Identifier: BSD-3-Clause
#include "planner/flipper_policy.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::planner {
namespace {

constexpr double kFastest_m_s = 5.0;
constexpr double kFastest_rad_s = 10.0;
constexpr double kMostFlipper_rad = 100.0;
constexpr double kProgress_m = 0.02;
constexpr double kProgress_rad = 0.05;
constexpr double kFarthestPlace_m = 1e5;

Status check(const FlipperPolicyConfig& c) {
  for (const double value : {c.lead_m, c.creep_m_s, c.map_off_m, c.steepest_rad, c.there_rad})
    if (!(value > 0.0 && value < 100.0)) return Status::out_of_range;
  if (!(std::fabs(c.feel_rad) < 1.6) || c.steepest_rad > 1.2) return Status::out_of_range;
  for (const rt::Nanoseconds span : {c.map_age_ns, c.attitude_age_ns, c.flipper_age_ns, c.look_ns, c.feel_ns,
                                     c.creep_ns, c.late_ns, c.stall_ns})
    if (span < 0 || span > 3600 * rt::kNanosecondsPerSecond) return Status::out_of_range;
  return Status::ok;
}

Status check(const FlipperInput& in) {
  const double places[] = {in.pose.x_m, in.pose.y_m, in.z_m};
  const double angles[] = {in.measured_rad[0], in.measured_rad[1], in.measured_rad[2], in.measured_rad[3],
                           in.mission_rad[0],  in.mission_rad[1],  in.mission_rad[2],  in.mission_rad[3],
                           in.pose.yaw_rad,    in.pitch_rad,       in.roll_rad};
  for (const double value : places)
    if (!std::isfinite(value)) return Status::not_finite;
  for (const double value : angles)
    if (!std::isfinite(value)) return Status::not_finite;
  if (!std::isfinite(in.arc.speed_m_s) || !std::isfinite(in.arc.turn_rad_s)) return Status::not_finite;
  for (const double value : places)
    if (std::fabs(value) > kFarthestPlace_m) return Status::out_of_range;
  for (const double value : angles)
    if (std::fabs(value) > kMostFlipper_rad) return Status::out_of_range;
  if (std::fabs(in.arc.speed_m_s) > kFastest_m_s || std::fabs(in.arc.turn_rad_s) > kFastest_rad_s)
    return Status::out_of_range;
  return Status::ok;
}

/// A stamp from the future is as little worth as an old one.
bool is_fresh(rt::Nanoseconds stamp_ns, rt::Nanoseconds now_ns, rt::Nanoseconds age_ns) {
  return stamp_ns <= now_ns && now_ns - stamp_ns <= age_ns;
}

FlipperSet set_of(const double (&angles)[rt::kFlippers]) {
  return {{angles[0], angles[1], angles[2], angles[3]}};
}

}  // namespace

FlipperPolicy::FlipperPolicy(const PostureVehicle& vehicle, const FlipperPolicyConfig& config)
    : config_(config),
      search_(vehicle, config.search),
      usable_(search_.usable() == Status::ok ? check(config) : search_.usable()) {}

void FlipperPolicy::enter(Stage stage, rt::Nanoseconds now_ns) {
  if (stage == stage_) return;
  stage_ = stage;
  since_ns_ = now_ns;
  switch (stage) {
    case Stage::none:
      break;
    case Stage::late:
      ++counters_.late;
      break;
    case Stage::look:
      ++counters_.looked;
      break;
    case Stage::feel:
      ++counters_.felt;
      break;
    case Stage::creep:
      ++counters_.crept;
      break;
    case Stage::stuck:
    case Stage::stalled:
    case Stage::stop:
      ++counters_.stopped;
      break;
  }
}

void FlipperPolicy::ask(const FlipperSet& angles, FlipperDecision& decision) {
  before_ = angles;
  has_before_ = true;
  std::copy(std::begin(angles.angle_rad), std::end(angles.angle_rad), decision.angle_rad);
}

bool FlipperPolicy::fall_back(const FlipperInput& input, FlipperDecision& decision) {
  const rt::Nanoseconds now = input.stamp_ns;
  if (!is_fresh(input.map_ns, now, config_.map_age_ns)) decision.reason = FlipperReason::stale_map;
  if (!is_fresh(input.attitude_ns, now, config_.attitude_age_ns))
    decision.reason = FlipperReason::lost_attitude;
  if (!is_fresh(input.flippers_ns, now, config_.flipper_age_ns))
    decision.reason = FlipperReason::lost_flippers;
  if (decision.reason == FlipperReason::none) return false;
  decision.verdict = FlipperVerdict::mission;
  decision.share = 1.0;
  decision.probability = 1.0;
  ++counters_.fell_back;
  stage_ = Stage::none;
  ask(set_of(input.mission_rad), decision);
  return true;
}

void FlipperPolicy::go(const FlipperInput& input, FlipperDecision& decision) {
  const JudgedFlippers& best = found_.best;
  decision.probability = best.probability;
  decision.margin_m = best.margin_m;
  ask(best.angles, decision);
  double way = 0.0;
  for (std::uint32_t f = 0; f < rt::kFlippers; ++f)
    way = std::max(way, std::fabs(best.angles.angle_rad[f] - input.measured_rad[f]));
  if (found_.stay.near_probability > config_.search.limit && way > config_.there_rad) {
    // As it stands it must not go on: the flippers first.
    if (stage_ != Stage::stuck) enter(Stage::late, input.stamp_ns);
    if (stage_ == Stage::late && input.stamp_ns - since_ns_ > config_.late_ns)
      enter(Stage::stuck, input.stamp_ns);
    decision.verdict = stage_ == Stage::stuck ? FlipperVerdict::stop : FlipperVerdict::slow;
    decision.reason = FlipperReason::flippers_late;
    decision.share = 0.0;
    return;
  }
  if (stage_ != Stage::stalled) enter(Stage::none, input.stamp_ns);
  const double wanted = std::fabs(input.arc.speed_m_s) + 0.3 * std::fabs(input.arc.turn_rad_s);
  const double fastest = config_.lead_m * config_.search.rate_rad_s;  // times the way, over 1 s
  const bool late = way * wanted > fastest;
  decision.share = late ? fastest / (way * wanted) : 1.0;
  decision.verdict = late ? FlipperVerdict::slow : FlipperVerdict::go;
  if (late) decision.reason = FlipperReason::flippers_late;
}

void FlipperPolicy::way_out(const FlipperInput& input, bool disagrees, FlipperDecision& decision) {
  const double limit = config_.search.limit;
  const rt::Nanoseconds now = input.stamp_ns;
  const bool missing = found_.under.missing > 0;
  decision.probability = found_.best.probability;
  decision.margin_m = found_.best.margin_m;
  decision.missing = found_.under.cells;
  decision.reason = disagrees ? FlipperReason::map_disagrees
                    : missing ? FlipperReason::missing_ground
                              : FlipperReason::unsafe_ground;
  if (stage_ == Stage::none || stage_ == Stage::late || stage_ == Stage::stuck || stage_ == Stage::stalled)
    enter(missing || disagrees ? Stage::look : Stage::stop, now);
  if (!missing && !disagrees) enter(Stage::stop, now);
  const bool near_safe = !disagrees && found_.near.near_probability <= limit;
  const bool stay_safe = !disagrees && found_.stay.near_probability <= limit;
  const bool feel_safe = !disagrees && stay_safe && found_.feel.near_probability <= limit;
  // Each way out that has had its time, or must not be gone, leads to the next.
  if (stage_ == Stage::look && (now - since_ns_ > config_.look_ns || input.looked)) enter(Stage::feel, now);
  if (stage_ == Stage::feel && (now - since_ns_ > config_.feel_ns || !feel_safe)) enter(Stage::creep, now);
  if (stage_ == Stage::creep && (now - since_ns_ > config_.creep_ns || !stay_safe)) enter(Stage::stop, now);
  const double wanted = std::fabs(input.arc.speed_m_s) + 0.3 * std::fabs(input.arc.turn_rad_s);
  FlipperSet angles = before_;
  switch (stage_) {
    case Stage::look:
      decision.verdict = FlipperVerdict::look;
      break;
    case Stage::feel: {
      const int leading = backward_ ? 2 : 0;
      angles.angle_rad[leading] = angles.angle_rad[leading + 1] = config_.feel_rad;
      decision.verdict = FlipperVerdict::feel;
      break;
    }
    case Stage::creep:
      if (near_safe) angles = found_.near.angles;
      decision.verdict = FlipperVerdict::creep;
      decision.share = std::min(1.0, config_.creep_m_s / wanted);
      break;
    default:
      decision.verdict = FlipperVerdict::stop;
      break;
  }
  ask(angles, decision);
}

void FlipperPolicy::watch_progress(const FlipperInput& input, FlipperDecision& decision) {
  const double x = input.pose.x_m - from_x_m_;
  const double y = input.pose.y_m - from_y_m_;
  const bool moved = x * x + y * y > kProgress_m * kProgress_m ||
                     std::fabs(input.pose.yaw_rad - from_yaw_rad_) > kProgress_rad;
  // Who creeps has a time of his own.
  if (moved || decision.share <= 0.0 || decision.verdict == FlipperVerdict::creep) {
    if (stage_ == Stage::stalled) stage_ = Stage::none;
    from_x_m_ = input.pose.x_m;
    from_y_m_ = input.pose.y_m;
    from_yaw_rad_ = input.pose.yaw_rad;
    moved_ns_ = input.stamp_ns;
    return;
  }
  if (input.stamp_ns - moved_ns_ <= config_.stall_ns) return;
  enter(Stage::stalled, input.stamp_ns);
  decision.verdict = FlipperVerdict::stop;
  decision.reason = FlipperReason::stalled;
  decision.share = 0.0;
}

Status FlipperPolicy::decide(const HeightView& view, const FlipperInput& input, FlipperDecision& decision) {
  if (usable_ != Status::ok) return usable_;
  const Status good = check(input);
  if (good != Status::ok) return good;
  if (started_ && input.stamp_ns == stamp_ns_) return Status::time_repeated;
  if (started_ && input.stamp_ns < stamp_ns_) return Status::time_backwards;
  FlipperDecision out;
  out.stamp_ns = input.stamp_ns;
  const bool backward = input.arc.speed_m_s < 0.0;
  const FlipperSet measured = set_of(input.measured_rad);
  const FlipperSet before = has_before_ ? before_ : measured;
  const bool fresh_enough = is_fresh(input.map_ns, input.stamp_ns, config_.map_age_ns) &&
                            is_fresh(input.attitude_ns, input.stamp_ns, config_.attitude_age_ns) &&
                            is_fresh(input.flippers_ns, input.stamp_ns, config_.flipper_age_ns);
  const double tilt = std::max(std::fabs(input.pitch_rad), std::fabs(input.roll_rad));
  const bool judged = fresh_enough && !input.arc.still() && tilt <= config_.steepest_rad;
  if (judged) {
    FlipperQuestion question;
    question.pose = input.pose;
    question.arc = input.arc;
    question.tilt = {input.pitch_rad, input.roll_rad};
    std::copy(std::begin(input.measured_rad), std::end(input.measured_rad), question.measured_rad);
    question.broken = input.broken;
    question.before = before;
    question.feel = measured;
    question.feel.angle_rad[backward ? 2 : 0] = config_.feel_rad;
    question.feel.angle_rad[backward ? 3 : 1] = config_.feel_rad;
    const Status searched = search_.search(view, question, found_);
    if (searched != Status::ok) return searched;
    out.tried = found_.tried;
    out.units = found_.units;
  }
  // From here on nothing fails.
  if (backward != backward_) stage_ = Stage::none;
  if (!started_ || backward != backward_) moved_ns_ = input.stamp_ns;
  backward_ = backward;
  before_ = before;
  started_ = true;
  stamp_ns_ = input.stamp_ns;
  if (!fall_back(input, out)) {
    if (judged) {
      const bool disagrees =
          !found_.stay_stands ? false : std::fabs(found_.stay_height_m - input.z_m) > config_.map_off_m;
      if (!disagrees && found_.best.probability <= config_.search.limit)
        go(input, out);
      else
        way_out(input, disagrees, out);
    } else {
      out.verdict = FlipperVerdict::stop;
      out.reason = input.arc.still() ? FlipperReason::still : FlipperReason::tilted;
      out.probability = 1.0;
      ask(before, out);
    }
  }
  if (out.verdict != FlipperVerdict::mission) watch_progress(input, out);
  out.speed_limit_m_s = out.share * std::fabs(input.arc.speed_m_s);
  decision = out;
  return Status::ok;
}

void FlipperPolicy::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "flipper policy")
      .fixed(config_, search_, usable_)
      .scratch(found_)
      .state(counters_)
      .by_hand(before_)
      .state(has_before_, started_, backward_, stage_, since_ns_, stamp_ns_, from_x_m_, from_y_m_,
             from_yaw_rad_, moved_ns_);
  archive.value(before_.angle_rad);
  if (!archive.is_reading()) return;
  bool good = stage_ <= Stage::stalled;
  for (const double angle : before_.angle_rad) good = good && std::fabs(angle) <= kMostFlipper_rad;
  if (good) return;
  archive.fail(Status::malformed, "flippers that were asked for what does not exist");
  before_ = {};
  stage_ = Stage::none;
}

}  // namespace sortie::planner
