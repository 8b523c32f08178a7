// SPDX-License-Identifier: BSD-3-Clause
// Who flies the multirotor: goals, requests, and what follows what.
#include "planner/uav_pilot.hpp"

#include <algorithm>
#include <cmath>

#include "planner/uav_path/uav_path.hpp"

namespace sortie::planner {
namespace {

using rt::Vector3;

// The reference follows the rotors' lag and comes to rest within some tenths of a second, never quite.
constexpr double kRest_m_s = 1e-6;
constexpr double kRest_m_s2 = 1e-4;
constexpr double kRest_m_s3 = 1e-2;

}  // namespace

UavPilot::UavPilot(const UavPilotConfig& config)
    : config_(config), control_(config.control), reach_m_(config.reach_m) {}

Status UavPilot::set_reach(double m) {
  if (!(m > 0.0)) return Status::out_of_range;
  reach_m_ = m;
  return Status::ok;
}

Status UavPilot::request(const rt::FlyRequest& request, rt::Nanoseconds now_ns) {
  const Status status = gate_.take(request, {0, config_.max_command_age_ns}, now_ns);
  if (status != Status::ok) return status;
  const auto mode = static_cast<rt::FlyMode>(request.mode);
  // Only a release ends a stop: whoever still sends goals must not start the rotors again.
  const bool stopped = step_ == PilotStep::stopped && remote_;
  if (stopped && mode == rt::FlyMode::go) return Status::ok;
  remote_ = mode != rt::FlyMode::release;
  held_ = remote_;
  if (mode == rt::FlyMode::go) {
    begin_goal({rt::to_vector(request.p_world_m), request.yaw_rad, 0});
  } else if (mode == rt::FlyMode::stop) {
    has_goal_ = false;
    step_ = PilotStep::stopped;
  } else if (mode == rt::FlyMode::land) {
    has_goal_ = false;
    control_.land();
  } else {  // hover, or back to the mission
    has_goal_ = false;
    control_.hover();
    if (step_ != PilotStep::landing && step_ != PilotStep::waiting && step_ != PilotStep::stopped &&
        step_ != PilotStep::landed)
      step_ = PilotStep::arrived;
    counted_ = true;
  }
  return Status::ok;
}

void UavPilot::begin_goal(const UavGoal& goal) {
  goal_ = goal;
  looking_ = false;
  has_goal_ = true;
  counted_ = false;
  const bool stands =
      step_ == PilotStep::waiting || step_ == PilotStep::landed || step_ == PilotStep::stopped;
  if (stands) {
    step_ = PilotStep::waiting;
  } else if (step_ != PilotStep::take_off) {
    rest();
  }
}

// What the controller decides by itself goes before everything.
void UavPilot::forced() {
  if (step_ == PilotStep::stopped || step_ == PilotStep::waiting) return;
  if (control_.phase() == UavPhase::landed) {
    step_ = PilotStep::landed;
  } else if (control_.phase() == UavPhase::land || control_.phase() == UavPhase::blind) {
    step_ = PilotStep::landing;
    has_goal_ = false;
  }
}

void UavPilot::start(const rt::UavState& state) {
  if (!has_goal_ || state.verdict != rt::UavVerdict::good) return;
  if (control_.start(state) != Status::ok) return;
  target_m_ = rt::to_vector(state.p_world_m) + Vector3{0, 0, config_.take_off_m};
  if (control_.set_goal(target_m_, control_.reference().yaw_rad) == Status::ok) step_ = PilotStep::take_off;
}

bool UavPilot::rests() const {
  const FlatReference& r = control_.reference();
  return rt::norm(r.v_m_s) < kRest_m_s && rt::norm(r.a_m_s2) < kRest_m_s2 && rt::norm(r.j_m_s3) < kRest_m_s3;
}

bool UavPilot::rests_at(const Vector3& p_m) const {
  return rests() && rt::norm(control_.reference().p_m - p_m) < 1e-6;
}

void UavPilot::rest() {
  control_.hover();
  step_ = PilotStep::resting;
}

void UavPilot::ask() {
  ++output_.question.number;
  rt::store(control_.reference().p_m, output_.question.from_m);
  rt::store(goal_.p_m, output_.question.to_m);
  step_ = PilotStep::asking;
}

void UavPilot::take_way(const UavWay& way, rt::Nanoseconds now_ns) {
  if (way.number != output_.question.number) return;
  const auto state = static_cast<PathState>(way.state);
  if (state == PathState::idle || state == PathState::running || state == PathState::found) return;
  if (state != PathState::done || way.points < 2 || way.blocked != 0) {
    ++output_.no_way;
    since_ns_ = now_ns;
    step_ = PilotStep::no_way;
    return;
  }
  point_count_ = std::min(way.points, UavWay::kMostPoints);
  for (std::uint32_t i = 0; i < point_count_; ++i) points_[i] = {way.x_m[i], way.y_m[i], way.z_m[i]};
  whole_ = way.whole != 0;
  leg_ = 0;
  next_leg();
}

void UavPilot::next_leg() {
  ++leg_;
  if (leg_ >= point_count_) {
    since_ns_ = output_.stamp_ns;
    step_ = whole_ ? PilotStep::arrived : PilotStep::resting;
    return;
  }
  target_m_ = points_[leg_];
  step_ = PilotStep::under_way;
  if (control_.set_goal(target_m_, goal_.yaw_rad) != Status::ok) rest();
}

void UavPilot::follow(const rt::UavState& state, const UavWay* way) {
  const bool gone =
      config_.plans && way != nullptr && way->number == output_.question.number && way->blocked != 0;
  // A profile that started anew is not on the line that was proved.
  const bool pushed = control_.counters().replanned != seen_replanned_;
  if (gone || pushed) {
    ++output_.replans;
    rest();
  } else if (state.verdict == rt::UavVerdict::dead) {
    ++output_.blinded;
    control_.hover();
    step_ = PilotStep::blinded;
  } else if (rests_at(target_m_)) {
    next_leg();
  }
}

// At the goal, or where it was told to hover.
void UavPilot::stay(const rt::UavState& state, rt::Nanoseconds now_ns) {
  if (!has_goal_) return;
  if (!counted_ && rt::norm(rt::to_vector(state.p_world_m) - goal_.p_m) < reach_m_) {
    counted_ = true;
    if (!looking_) ++output_.reached;
    since_ns_ = now_ns;
  }
  if (!counted_ || now_ns - since_ns_ < goal_.wait_ns) return;
  has_goal_ = false;
  if (looking_) {
    ready_ = placed_ && next_look_ == 0;
    next_look_ = placed_ ? 0 : (next_look_ + 1) % look_count_;
    if (next_look_ == 0) ++rounds_;
  } else if (!remote_) {
    ++next_goal_;
  }
}

void UavPilot::decide(const rt::UavState& state, const UavWay* way, rt::Nanoseconds now_ns) {
  switch (step_) {
    case PilotStep::waiting:
      start(state);
      break;
    case PilotStep::take_off:
      if (rests_at(target_m_)) step_ = has_goal_ ? PilotStep::resting : PilotStep::arrived;
      break;
    case PilotStep::resting:
      if (!rests() || state.verdict != rt::UavVerdict::good) break;
      if (config_.plans && !looking_) {
        ask();
      } else {
        points_[0] = control_.reference().p_m;
        points_[1] = goal_.p_m;
        point_count_ = 2;
        whole_ = true;
        leg_ = 0;
        next_leg();
      }
      break;
    case PilotStep::asking:
      if (way != nullptr) take_way(*way, now_ns);
      break;
    case PilotStep::no_way:
      if (now_ns - since_ns_ >= config_.ask_again_ns) step_ = PilotStep::resting;
      break;
    case PilotStep::under_way:
      follow(state, way);
      break;
    case PilotStep::blinded:
      if (state.verdict == rt::UavVerdict::good) rest();
      break;
    case PilotStep::arrived:
      stay(state, now_ns);
      break;
    case PilotStep::landing:
    case PilotStep::landed:
    case PilotStep::stopped:
      break;
  }
  seen_replanned_ = control_.counters().replanned;
}

void UavPilot::update(const rt::UavState& state, const UavWay* way, rt::Nanoseconds now_ns) {
  if (!started_) {
    started_ = true;
    start_ns_ = now_ns;
  }
  output_.stamp_ns = now_ns;
  choose_goal(state, now_ns);
  forced();
  decide(state, way, now_ns);
  if (step_ == PilotStep::stopped || step_ == PilotStep::waiting) {
    const std::uint32_t rotors = std::min(config_.control.model.rotors, rt::kMaxRotors);
    output_.command = {};
    output_.command.stamp_ns = now_ns;
    output_.command.rotors = rotors;
  } else {
    // A state that was refused is counted by the controller, which then goes on from its last command.
    static_cast<void>(control_.update(state, output_.command));
    output_.command.stamp_ns = now_ns;
    output_.command.flags = kRotorsEnabled;
  }
  forced();
  if (step_ == PilotStep::landed) output_.command.flags = 0;
  put_out(state, now_ns);
}

void UavPilot::put_out(const rt::UavState& state, rt::Nanoseconds now_ns) {
  const FlatReference& r = control_.reference();
  output_.stamp_ns = now_ns;
  output_.step = static_cast<std::uint32_t>(step_);
  output_.phase = static_cast<std::uint32_t>(control_.phase());
  output_.verdict = static_cast<std::uint32_t>(state.verdict);
  output_.remote = remote_ ? 1 : 0;
  output_.mission = next_goal_;
  output_.leg = leg_;
  output_.request_counter = gate_.newest;
  rt::store(goal_.p_m, output_.goal_m);
  rt::store(r.p_m, output_.setpoint_m);
  rt::store(r.v_m_s, output_.setpoint_v_m_s);
  output_.setpoint_yaw_rad = r.yaw_rad;
  output_.error_m = rt::norm(rt::to_vector(state.p_world_m) - r.p_m);
  output_.control = control_.counters();
  output_.requests = gate_.counters;
}

void UavPilot::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "uav pilot")
      .fixed(config_, mission_, goals_, looks_, look_count_)
      .by_hand(next_goal_, next_look_, point_count_, leg_)
      .state(control_, reach_m_, gate_, step_, started_, has_goal_, remote_, held_, looking_, rounds_,
             base_m_, placed_, ready_, p_own_map_m_, q_own_map_, goal_, target_m_, points_, whole_, counted_,
             seen_replanned_, start_ns_, since_ns_, output_);
  archive.bounded(next_goal_, goals_);
  archive.bounded(next_look_, look_count_ > 0 ? look_count_ - 1 : 0);
  archive.bounded(point_count_, UavWay::kMostPoints);
  archive.bounded(leg_, UavWay::kMostPoints);
  // What was held back is no field of the output.
  if (archive.is_reading()) output_.requests = gate_.counters;
}

}  // namespace sortie::planner
