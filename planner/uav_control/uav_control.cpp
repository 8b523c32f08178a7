// SPDX-License-Identifier: BSD-3-Clause
// Flies a multirotor to where it is told: what it is doing, and when that changes.
#include "planner/uav_control/uav_control.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::planner {
namespace {

using rt::Vector3;

bool is_finite_state(const rt::UavState& s) {
  return rt::is_finite(rt::to_vector(s.p_world_m)) && rt::is_finite(rt::to_vector(s.v_world_m_s)) &&
         rt::is_finite(rt::to_vector(s.w_body_rad_s)) && rt::is_finite(rt::to_vector(s.d_world_m_s2)) &&
         std::fabs(rt::squared_norm(rt::to_quaternion(s.q_world_body)) - 1.0) < 1e-3 &&
         rt::norm(rt::to_vector(s.p_world_m)) < 1e6 && rt::norm(rt::to_vector(s.v_world_m_s)) < 1e3 &&
         rt::norm(rt::to_vector(s.w_body_rad_s)) < 1e3;
}

UavModel usable(const UavModel& model) {
  if (check(model) == Status::ok) return model;
  UavModel some = RegularMultirotor{}.model;  // any vehicle: it is never flown, but its parts can be built
  place_rotors(some, some.rotors, 0.2, 0.5);
  return some;
}

double usable_period(double period_s) { return period_s >= 1e-4 && period_s <= 0.1 ? period_s : 0.01; }

}  // namespace

UavControl::UavControl(const UavControlConfig& config) : UavControl(config, usable(config.model)) {}

UavControl::UavControl(const UavControlConfig& config, const UavModel& model)
    : config_(config),
      allocation_(model),
      rotors_(model, usable_period(config.period_s)),
      watch_(model, usable_period(config.period_s)),
      profile_(config.profile, usable_period(config.period_s)),
      lag_(0.5 * (model.tau_up_s + model.tau_down_s), usable_period(config.period_s)),
      tau_s_(0.5 * (config.model.tau_up_s + config.model.tau_down_s)),
      tilt_slope_(rt::tan(std::min(config.max_tilt_rad, 1.2))) {
  status_ = design_gains(config.model, config.period_s, config.weights, gains_);
  last_.rotors = std::min(config.model.rotors, rt::kMaxRotors);
}

Status UavControl::start(const rt::UavState& state) {
  if (status_ != Status::ok) return status_;
  if (!is_finite_state(state)) return Status::not_finite;
  FlatReference from;
  from.p_m = rt::to_vector(state.p_world_m);
  from.v_m_s = rt::to_vector(state.v_world_m_s);
  from.yaw_rad = rt::yaw_of(rt::to_quaternion(state.q_world_body));
  profile_.rest(from.p_m, from.yaw_rad);
  lag_.reset();
  if (rt::norm(from.v_m_s) > 0.05) {
    profile_.brake(lag_.ahead(from));
    profile_.stop();
  }
  rotors_.reset(1.0);
  made_ = made_last_ = allocation_.wrench(rotors_.thrust_n());
  watch_.reset();
  integral_ = {};
  mean_thrust_m_s2_ = config_.model.gravity_m_s2;
  have_stamp_ = false;
  stateless_s_ = standing_s_ = 0.0;
  phase_ = UavPhase::hold;
  reference_ = from;
  return Status::ok;
}

void UavControl::step_profile() {
  const FlatReference start = profile_.now();
  profile_.step();
  reference_ = lag_.step(start, profile_.now().s_m_s4);
}

void UavControl::begin_hold() {
  if (phase_ == UavPhase::track) {
    lag_.reset();
    profile_.brake(lag_.ahead(reference_));
  }
  profile_.set_speed_share(1.0);
  phase_ = UavPhase::hold;
}

Status UavControl::set_goal(const Vector3& p_m, double yaw_rad) {
  if (phase_ == UavPhase::idle || allocation_.lost_count() > 0) return Status::not_supported;
  const Status status = profile_.set_goal(p_m, yaw_rad);
  if (status != Status::ok) {
    ++counters_.goals_refused;
    return status;
  }
  begin_hold();
  return Status::ok;
}

bool UavControl::continues(const FlatReference& next) const {
  // A reference goes on from the one before; what jumps is a goal, not a path. Twice what the limits allow in
  // a period, and a little for one that begins.
  const double h = 2.0 * config_.period_s;
  const auto within = [](const Vector3& v, double most) { return rt::dot(v, v) <= most * most; };
  return within(next.v_m_s, config_.max_reference_m_s) && within(next.a_m_s2, config_.max_reference_m_s2) &&
         within(next.j_m_s3, config_.max_reference_m_s3) &&
         within(next.s_m_s4, 20.0 * config_.max_reference_m_s3) &&
         within(next.p_m - reference_.p_m, 0.1 + h * config_.max_reference_m_s) &&
         within(next.v_m_s - reference_.v_m_s, 0.1 + h * config_.max_reference_m_s2) &&
         within(next.a_m_s2 - reference_.a_m_s2, 0.1 + h * config_.max_reference_m_s3);
}

Status UavControl::track(const FlatReference& next) {
  const auto refused = [this](Status why) {
    ++counters_.references_refused;
    return why;
  };
  if (phase_ == UavPhase::idle || allocation_.lost_count() > 0) return Status::not_supported;
  if (!is_finite(next)) return refused(Status::not_finite);
  if (!continues(next)) return refused(Status::out_of_range);
  phase_ = UavPhase::track;
  lag_.reset();
  reference_ = next;
  fresh_track_ = true;
  silent_s_ = 0.0;
  return Status::ok;
}

void UavControl::hover() {
  if (phase_ != UavPhase::hold && phase_ != UavPhase::track) return;
  begin_hold();
  profile_.stop();
}

void UavControl::land() {
  if (phase_ == UavPhase::idle || phase_ == UavPhase::landed || phase_ == UavPhase::land) return;
  begin_hold();
  profile_.stop();
  phase_ = UavPhase::land;
}

Status UavControl::admit(const rt::UavState& state) {
  if (!is_finite_state(state)) return Status::not_finite;
  if (have_stamp_ && state.stamp_ns == stamp_ns_) return Status::time_repeated;
  if (have_stamp_ && state.stamp_ns < stamp_ns_) return Status::time_backwards;
  have_stamp_ = true;
  stamp_ns_ = state.stamp_ns;
  return Status::ok;
}

void UavControl::watch_rotors(const Vector3& w) {
  const Vector3 mean = 0.5 * (made_.torque_n_m + made_last_.torque_n_m);
  const std::uint32_t lost = watch_.update(w, rotors_.mean_n(), mean);
  // One rotor: what a vehicle without two does is too far from the model to tell them apart.
  if (lost == RotorWatch::kNone || allocation_.lost_count() > 0 || !allocation_.lose(lost)) return;
  ++counters_.rotors_lost;
  made_ = made_last_ = allocation_.wrench(rotors_.thrust_n());
  watch_.reset();
  land();
}

void UavControl::step_reference(const rt::UavState& state) {
  const Vector3 p = rt::to_vector(state.p_world_m);
  if (phase_ == UavPhase::track) {
    if (fresh_track_) {
      fresh_track_ = false;
      return;
    }
    silent_s_ += config_.period_s;
    if (silent_s_ <= config_.track_timeout_s) {  // goes on as it was
      const double h = config_.period_s;
      reference_.p_m = reference_.p_m + h * reference_.v_m_s;
      reference_.yaw_rad += h * reference_.yaw_rate_rad_s;
      return;
    }
    hover();
  }
  if (phase_ == UavPhase::blind) {
    profile_.rest(p, rt::yaw_of(rt::to_quaternion(state.q_world_body)));
    lag_.reset();
    reference_ = profile_.now();
    reference_.v_m_s.z = -config_.sink_m_s;
    return;
  }
  if (phase_ == UavPhase::hold && rt::norm(p - reference_.p_m) > config_.max_position_error_m) {
    ++counters_.replanned;
    FlatReference here = profile_.now();
    here.p_m = p;
    here.v_m_s = rt::to_vector(state.v_world_m_s);
    here.a_m_s2 = here.j_m_s3 = {};
    lag_.reset();
    profile_.brake(lag_.ahead(here));
  }
  if (phase_ == UavPhase::land) {
    const Vector3 at = profile_.goal_m();
    const double below = std::min(profile_.now().p_m.z, p.z) - 2.0;
    profile_.set_speed_share(config_.sink_m_s / config_.profile.climb_m_s);
    // Far below but never out of range: the ground ends it.
    if (profile_.set_goal({at.x, at.y, below}, profile_.goal_yaw_rad()) != Status::ok) profile_.stop();
    // On the ground the reference waits a little below the vehicle.
    if (profile_.now().p_m.z > p.z - 0.45) {
      step_profile();
    } else {
      lag_.reset();
      reference_ = profile_.now();
    }
  } else {
    step_profile();
  }
}

bool UavControl::stands(const Vector3& p, const Vector3& v) {
  const bool sinking = phase_ == UavPhase::land || phase_ == UavPhase::blind;
  const bool below = phase_ == UavPhase::blind || reference_.p_m.z < p.z - 0.25;
  standing_s_ = sinking && below && rt::norm(v) < 0.12 ? standing_s_ + config_.period_s : 0.0;
  return standing_s_ > 0.4;
}

Status UavControl::update(const rt::UavState& state, rt::RotorCommand& command) {
  ++counters_.steps;
  command = {};
  command.stamp_ns = state.stamp_ns;
  command.rotors = last_.rotors;
  if (status_ != Status::ok) return status_;
  if (phase_ == UavPhase::idle || phase_ == UavPhase::landed) return Status::ok;
  const Status admitted = admit(state);
  if (admitted != Status::ok) {
    ++counters_.states_refused;
    carry_on(command);
    return admitted;
  }
  stateless_s_ = 0.0;
  const Vector3 p = rt::to_vector(state.p_world_m);
  const Vector3 v = rt::to_vector(state.v_world_m_s);
  if (state.verdict == rt::UavVerdict::lost) {
    phase_ = UavPhase::blind;
  } else if (phase_ == UavPhase::blind) {  // found again: it lands all the same, now knowing where
    profile_.rest(p, rt::yaw_of(rt::to_quaternion(state.q_world_body)));
    phase_ = UavPhase::land;
  }
  // What does not sink although it should stands on something, which holds it against its rotors.
  const bool lands = phase_ == UavPhase::land || phase_ == UavPhase::blind;
  if (lands && reference_.v_m_s.z < -0.5 * config_.sink_m_s && v.z > 0.3 * reference_.v_m_s.z) {
    watch_.reset();
  } else {
    watch_rotors(rt::to_vector(state.w_body_rad_s));
  }
  step_reference(state);
  if (stands(p, v)) {
    phase_ = UavPhase::landed;
    return Status::ok;
  }
  const RotorThrusts thrusts = allocation_.share(control(state));
  thrust_limited_ = thrusts.limited;
  if (thrusts.limited) ++counters_.thrust_limited;
  emit(thrusts, command);
  return Status::ok;
}

void UavControl::emit(const RotorThrusts& thrusts, rt::RotorCommand& command) {
  const UavModel& model = config_.model;
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    const double force = std::clamp(thrusts.force_n[i], 0.0, model.max_thrust_n());
    command.speed_rad_s[i] = std::min(std::sqrt(force / model.thrust_n_s2), model.max_speed_rad_s);
  }
  rotors_.step(command.speed_rad_s);
  made_last_ = made_;
  made_ = allocation_.wrench(rotors_.thrust_n());
  mean_thrust_m_s2_ = 0.5 * (made_.thrust_n + made_last_.thrust_n) / model.mass_kg;
  last_ = command;
}

void UavControl::carry_on(rt::RotorCommand& command) {
  // A short gap is bridged with the last command; then all rotors make a little less than the weight.
  stateless_s_ += config_.period_s;
  RotorThrusts even;
  if (stateless_s_ <= config_.state_timeout_s) {
    for (std::uint32_t i = 0; i < last_.rotors; ++i)
      even.force_n[i] = config_.model.thrust_n_s2 * last_.speed_rad_s[i] * last_.speed_rad_s[i];
  } else {
    even = allocation_.share({0.95 * config_.model.mass_kg * config_.model.gravity_m_s2, {}});
  }
  watch_.reset();
  emit(even, command);
}

}  // namespace sortie::planner
