// SPDX-License-Identifier: BSD-3-Clause
// What a pilot is told about the vehicle.
#include "tests/bench/uav/flight_senses.hpp"

#include <cmath>

namespace sortie::bench {

struct FlightSenses::Estimated {};

FlightSenses::FlightSenses(const FlightSetup& setup)
    : setup_(setup), random_(setup.seed, 0x73656e73), observer_({setup.observer_hz, 8.0}) {}
FlightSenses::~FlightSenses() { delete estimated_; }
void FlightSenses::observe(hil::MultirotorPlant&) {}
double FlightSenses::estimate_rms_m() const { return 0.0; }
rt::UavState FlightSenses::state(hil::MultirotorPlant& plant, double now_s, double expected_m_s2) {
  return true_state(plant, now_s, expected_m_s2);
}

rt::UavState FlightSenses::true_state(hil::MultirotorPlant& plant, double now_s, double expected_m_s2) {
  const StateNoise& noise = setup_.noise;
  const auto draw = [this](double sigma) {
    const double x = random_.normal();
    const double y = random_.normal();
    const double z = random_.normal();
    return rt::Vector3{sigma * x, sigma * y, sigma * z};
  };
  const auto plain = [](const hil::Vec3& v) { return rt::Vector3{v.x, v.y, v.z}; };
  const hil::MultirotorState& truth = plant.state();
  const hil::InertialTruth inertial = plant.take_inertial();
  rt::UavState state;
  state.stamp_ns = 1 + static_cast<rt::Nanoseconds>(std::llround(now_s * 1e9));
  state.verdict = rt::UavVerdict::good;
  late_.push_back(truth.p_world_m);
  const auto delay = static_cast<std::size_t>(std::lround(setup_.position_delay_s / setup_.control.period_s));
  while (late_.size() > delay + 1) late_.pop_front();
  rt::store(plain(late_.front()) + draw(noise.position_m), state.p_world_m);
  rt::store(plain(truth.v_world_m_s) + draw(noise.velocity_m_s), state.v_world_m_s);
  const hil::Quat& q = truth.q_world_body;
  const rt::Quaternion noisy =
      rt::normalised(rt::Quaternion{q.w, q.x, q.y, q.z} * rt::exp_rotation(draw(noise.attitude_rad)));
  rt::store(noisy, state.q_world_body);
  rt::store(plain(truth.w_body_rad_s) + draw(noise.rate_rad_s), state.w_body_rad_s);
  const rt::Vector3 force = plain(inertial.acc_m_s2) + draw(noise.force_m_s2);
  if (started_ && setup_.observer) {
    observer_.update(force, rt::slerp(last_q_, noisy, 0.5), expected_m_s2, setup_.control.period_s);
    rt::store(observer_.value_m_s2(), state.d_world_m_s2);
  }
  last_q_ = noisy;
  started_ = true;
  return state;
}

}  // namespace sortie::bench
