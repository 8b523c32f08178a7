// SPDX-License-Identifier: BSD-3-Clause
// One update of the drive: reasons to stop, then who is in control, then the ramps, then the tracks.
#include "planner/ugv_drive.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::planner {
namespace {
constexpr std::int64_t kMostSteps = 32;  // after a longer pause the drives have stopped by themselves

bool is_positive(double value) { return value > 0.0 && std::isfinite(value); }

Status take_limit(double value, double& limit) {
  if (!is_positive(value)) return Status::out_of_range;
  limit = value;
  return Status::ok;
}
}  // namespace

UgvDrive::UgvDrive(const UgvDriveConfig& config)
    : config_(config), follower_(config.follower), guard_(config.guard), halted_(config.start_halted) {}

Status UgvDrive::set_max_speed(double m_s) { return take_limit(m_s, config_.max_speed_m_s); }

Status UgvDrive::set_max_turn_rate(double rad_s) { return take_limit(rad_s, config_.max_turn_rad_s); }

Status UgvDrive::set_max_acceleration(double m_s2) {
  if (m_s2 > config_.stop.acceleration) return Status::out_of_range;
  return take_limit(m_s2, config_.ramps.speed.acceleration);
}

Status UgvDrive::set_track_width(double m) {
  if (!is_positive(m)) return Status::out_of_range;
  const double middle = 0.5 * (config_.icr.y_left_m + config_.icr.y_right_m);
  config_.icr.y_left_m = middle + 0.5 * m;
  config_.icr.y_right_m = middle - 0.5 * m;
  return Status::ok;
}

Status UgvDrive::set_goal(double x_m, double y_m) {
  if (!std::isfinite(x_m) || !std::isfinite(y_m)) return Status::not_finite;
  if (std::fabs(x_m) > kFarthestGoal_m || std::fabs(y_m) > kFarthestGoal_m) return Status::out_of_range;
  goal_ = ++goals_;
  goal_m_[0] = x_m;
  goal_m_[1] = y_m;
  arrived_ = false;
  return Status::ok;
}

Status UgvDrive::request(const rt::DriveRequest& request, rt::Nanoseconds now_ns) {
  const Status status =
      gate_.take(request, {config_.postures, config_.max_command_age_ns, config_.finds_ways}, now_ns);
  if (status != Status::ok) return status;
  const auto mode = static_cast<rt::DriveMode>(request.mode);
  const bool has_control = remote_ && static_cast<rt::DriveMode>(request_.mode) == rt::DriveMode::drive;
  const bool anew = (request.flags & ~request_.flags & rt::kDriveAnew) != 0;
  request_ = plain(request);
  remote_ = mode != rt::DriveMode::release && mode != rt::DriveMode::go;
  if (mode == rt::DriveMode::release && arrived_) goal_ = 0;
  // Judged by the gate: it is taken. Who asks for the same place again, because he has no answer yet, asks
  // for no other way.
  const bool is_same =
      goal_ != 0 && !arrived_ && goal_m_[0] == request.goal_x_m && goal_m_[1] == request.goal_y_m;
  if (mode == rt::DriveMode::go && !is_same) static_cast<void>(set_goal(request.goal_x_m, request.goal_y_m));
  if (mode == rt::DriveMode::emergency) emergency_ = true;
  if (mode == rt::DriveMode::emergency_end) emergency_ = false;
  // Only a release ends a halt: a stream of speeds that goes on in the background must not. What ends an
  // emergency stop ends no halt.
  if (mode == rt::DriveMode::release) {
    halted_ = emergency_;
  } else if (mode != rt::DriveMode::drive && mode != rt::DriveMode::go) {
    halted_ = true;
  }
  const bool takes_control = mode == rt::DriveMode::drive && (!has_control || anew);
  const bool sets_off = mode == rt::DriveMode::release || mode == rt::DriveMode::go;
  if (!halted_ && (sets_off || takes_control)) ++asked_;
  if (mode == rt::DriveMode::release) follower_.encourage();
  if (request_.posture >= 0) posture_ = request_.posture;
  return status;
}

Status UgvDrive::update(const rt::PoseEstimate& pose, const UgvDriveInputs& inputs, rt::Nanoseconds now_ns) {
  if (started_ && now_ns == last_ns_) return Status::time_repeated;
  if (started_ && now_ns < last_ns_) return Status::time_backwards;
  const std::int64_t steps = started_ ? std::min(kMostSteps, (now_ns - last_ns_) / config_.step_ns) : 0;
  last_ns_ = now_ns;
  begin(now_ns);
  if (has_goal() && inputs.guide.arrived) arrived_ = true;
  const MissionStep* step = mission_.at(now_ns - start_ns_);
  const DriveSource source = in_control(step);
  guard_.update(facts(source, inputs, now_ns), pose, limiter_.at_rest(), now_ns);
  SpeedTurn wish = choose(source, step, pose, inputs.guide, now_ns);
  // What the follower has found just now, the guard hears of before anything moves on.
  guard_.update(facts(source, inputs, now_ns), pose, limiter_.at_rest(), now_ns);
  if (!guard_.clear()) wish = {};
  const SpeedTurn fitted = fit(wish, limits());
  const bool shortened = fitted.speed_m_s != wish.speed_m_s || fitted.turn_rad_s != wish.turn_rad_s;
  const TwistRamps ramps = guard_.clear() ? config_.ramps : stop_ramps();
  for (std::int64_t i = 0; i < steps; ++i)
    limiter_.step(fitted, limits(), ramps, rt::to_seconds(config_.step_ns));
  put_out(source, shortened, inputs.guide, now_ns);
  return Status::ok;
}

// The start is asked for once, when the wait is over, one update after the first at the soonest.
void UgvDrive::begin(rt::Nanoseconds now_ns) {
  if (!started_) {
    start_ns_ = now_ns;
  } else if (!begun_ && now_ns - start_ns_ >= config_.start_wait_ns) {
    begun_ = true;
    if (!halted_) ++asked_;
  }
  started_ = true;
}

TwistLimits UgvDrive::limits() const {
  return {config_.max_speed_m_s, config_.max_turn_rad_s, config_.max_track_m_s, config_.icr.lever_m()};
}

TwistRamps UgvDrive::stop_ramps() const {
  const TwistRamps& usual = config_.ramps;
  const double firmer = config_.stop.acceleration / usual.speed.acceleration;
  const double faster = config_.stop.jerk / usual.speed.jerk;
  return {config_.stop, {usual.turn.acceleration * firmer, usual.turn.jerk * faster}};
}

DriveSource UgvDrive::in_control(const MissionStep* step) const {
  if (remote_) return DriveSource::remote;
  if (has_goal()) return DriveSource::goal;
  if (mission_.empty()) return DriveSource::route;
  if (step == nullptr) return DriveSource::none;
  return step->route ? DriveSource::route : DriveSource::mission;
}

DriveFacts UgvDrive::facts(DriveSource source, const UgvDriveInputs& inputs, rt::Nanoseconds now_ns) const {
  DriveFacts facts;
  facts.starting = now_ns - start_ns_ < config_.start_wait_ns;
  facts.halted = halted_;
  facts.emergency = emergency_;
  facts.command_stale = remote_ && !halted_ && now_ns - request_.stamp_ns > config_.max_command_age_ns;
  facts.imu_stale = inputs.imu_stale;
  facts.odometry_stale = inputs.odometry_stale;
  facts.stuck = source == DriveSource::route && follower_.stuck();
  facts.no_way = source == DriveSource::goal && !arrived_ && !inputs.guide.has_way;
  facts.though_tilted = remote_ && (request_.flags & rt::kDriveThoughTilted) != 0;
  return facts;
}

/// What the one in control wishes. The mission's clock goes on whoever drives; the follower is asked only
/// where the robot may move, or has to find a way out of being stuck.
SpeedTurn UgvDrive::choose(DriveSource source, const MissionStep* step, const rt::PoseEstimate& pose,
                           const GoalGuide& guide, rt::Nanoseconds now_ns) {
  if (source != DriveSource::remote && mission_.posture() >= 0) posture_ = mission_.posture();
  const bool only_stuck = guard_.reasons() == kStopStuck;
  if (source == DriveSource::route && (guard_.clear() || only_stuck))
    return follower_.wish(pose, limits(), config_.ramps, now_ns);
  follower_.pause();
  if (source == DriveSource::goal) return arrived_ ? SpeedTurn{} : guide.wish;
  if (source == DriveSource::mission) return {step->speed_m_s, step->turn_rad_s};
  if (source != DriveSource::remote || halted_) return {};
  const SpeedTurn asked{request_.speed_m_s, request_.turn_rad_s};
  if (!guard_.tilted()) return asked;
  TwistLimits slow = limits();
  slow.max_track_m_s = std::min(slow.max_track_m_s, config_.recover_speed_m_s);
  return fit(asked, slow);
}

// A mission wants motion until its end, which it does not know: its pauses are its own, and no request begins
// with what comes after them.
bool UgvDrive::wanted() const {
  if (!begun_ || halted_) return false;
  if (has_goal() && !remote_) return !arrived_;
  return remote_ || !mission_.empty() || !follower_.done();
}

bool UgvDrive::follows_guide() const {
  return output_.source == static_cast<std::uint32_t>(DriveSource::goal) && !arrived_ &&
         (output_.stop & ~std::uint32_t{kStopNoWay}) == 0;
}

void UgvDrive::put_out(DriveSource source, bool shortened, const GoalGuide& guide, rt::Nanoseconds now_ns) {
  const SpeedTurn now = limiter_.now();
  const TrackSpeeds tracks = config_.icr.to_tracks(now.speed_m_s, now.turn_rad_s);
  const bool on_route = source == DriveSource::route;
  const bool to_goal = source == DriveSource::goal;
  const bool is_done = to_goal ? arrived_ : follower_.done();
  const bool idle = source == DriveSource::none || ((on_route || to_goal) && is_done);
  output_.stamp_ns = now_ns;
  output_.left_m_s = tracks.left_m_s;
  output_.right_m_s = tracks.right_m_s;
  output_.speed_m_s = now.speed_m_s;
  output_.turn_rad_s = now.turn_rad_s;
  output_.waypoint = follower_.waypoint();
  output_.source = static_cast<std::uint32_t>(source);
  output_.flags = 0;
  const auto set = [this](bool holds, DriveFlags flag) { output_.flags |= holds ? flag : 0u; };
  set(!limiter_.at_rest() || (guard_.clear() && !idle), kDriveEnabled);
  set(is_done, kDriveDone);
  set((on_route && follower_.turning()) || (to_goal && guide.turning), kDriveTurning);
  set((on_route && follower_.reversing()) || (to_goal && guide.reversing), kDriveReversing);
  set(!guard_.clear(), kDriveStopping);
  set(shortened, kDriveShortened);
  set(guard_.tilted(), kDriveTilted);
  set(wanted(), kDriveWanted);
  set(emergency_, kDriveEmergency);
  set(guide.lost, kDriveOffWay);
  output_.stop = guard_.reasons();
  output_.posture = posture_;
  output_.request_counter = gate_.newest;
  output_.asked = asked_;
  output_.goal = goal_;
  output_.goal_x_m = goal_m_[0];
  output_.goal_y_m = goal_m_[1];
  output_.way_series = guide.series;
  output_.way_step = guide.step;
  output_.stops = guard_.counters();
  output_.requests = gate_.counters;
}

void UgvDrive::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "ugv drive")
      .fixed(config_)
      .state(follower_, mission_, guard_, gate_, limiter_, request_, output_, start_ns_, last_ns_, started_,
             remote_, halted_, emergency_, begun_, asked_, posture_, goals_, goal_, goal_m_, arrived_);
  // What was held back is no field of the output.
  if (archive.is_reading()) output_.requests = gate_.counters;
}

}  // namespace sortie::planner
