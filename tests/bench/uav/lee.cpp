// SPDX-License-Identifier: BSD-3-Clause
// The geometric controller of RotorS, from its description.
#include "tests/bench/uav/lee.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string_view>

namespace sortie::bench {

LeeGains lee_gains(const char* vehicle) {
  LeeGains gains;
  if (std::string_view(vehicle) == "firefly") {
    gains.position.setConstant(6.0);
    gains.velocity.setConstant(4.7);
    gains.attitude = {3.0, 3.0, 0.15};
    gains.rate = {0.52, 0.52, 0.18};
  }
  return gains;
}

LeeGains with_integrator(LeeGains gains, double share_hz) {
  gains.integral = share_hz * gains.position;
  return gains;
}

LeeController::LeeController(const planner::UavModel& model, const LeeGains& gains, double period_s)
    : model_(model), gains_(gains), dt_(period_s) {
  const Eigen::Vector3d inertia(model.inertia_kg_m2.x, model.inertia_kg_m2.y, model.inertia_kg_m2.z);
  normal_attitude_ = gains.attitude.cwiseQuotient(inertia);
  normal_rate_ = gains.rate.cwiseQuotient(inertia);
  Eigen::Matrix4Xd allocation(4, model.rotors);
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    const planner::UavRotor& rotor = model.rotor[i];
    allocation.col(i) << rotor.place_m.y * model.thrust_n_s2, -rotor.place_m.x * model.thrust_n_s2,
        -rotor.direction * model.thrust_n_s2 * model.moment_m, model.thrust_n_s2;
  }
  Eigen::Matrix4d inertias = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 3; ++i) inertias(i, i) = inertia(i);
  to_squares_ = allocation.transpose() * (allocation * allocation.transpose()).inverse() * inertias;
}

void LeeController::update(const rt::UavState& state, const planner::FlatReference& reference,
                           rt::RotorCommand& command) {
  const auto vector = [](const rt::Vector3& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
  const Eigen::Map<const Eigen::Vector3d> p(state.p_world_m);
  const Eigen::Map<const Eigen::Vector3d> v(state.v_world_m_s);
  const Eigen::Map<const Eigen::Vector3d> w(state.w_body_rad_s);
  const double* q = state.q_world_body;
  const Eigen::Matrix3d r = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();

  const Eigen::Vector3d e_p = p - vector(reference.p_m);
  const Eigen::Vector3d e_v = v - vector(reference.v_m_s);
  if (!limited_) {  // anti-windup: nothing is added while a rotor is at its limit
    integral_n_ += dt_ * gains_.integral.cwiseProduct(e_p);
    integral_n_ = integral_n_.cwiseMax(-gains_.integral_limit_n).cwiseMin(gains_.integral_limit_n);
  }
  const Eigen::Vector3d acceleration =
      (gains_.position.cwiseProduct(e_p) + gains_.velocity.cwiseProduct(e_v) + integral_n_) / model_.mass_kg -
      model_.gravity_m_s2 * up - vector(reference.a_m_s2);

  const rt::SinCos yaw = rt::sincos(reference.yaw_rad);
  const Eigen::Vector3d b3 = -acceleration / acceleration.norm();
  const Eigen::Vector3d b2 = b3.cross(Eigen::Vector3d(yaw.cos, yaw.sin, 0)).normalized();
  Eigen::Matrix3d wanted;
  wanted << b2.cross(b3), b2, b3;
  const Eigen::Matrix3d skew = 0.5 * (wanted.transpose() * r - r.transpose() * wanted);
  const Eigen::Vector3d e_r(skew(2, 1), skew(0, 2), skew(1, 0));
  const Eigen::Vector3d e_w = w - wanted.transpose() * r * Eigen::Vector3d(0, 0, reference.yaw_rate_rad_s);
  const Eigen::Vector3d turn =
      -normal_attitude_.cwiseProduct(e_r) - normal_rate_.cwiseProduct(e_w) + w.cross(w);

  Eigen::Vector4d wish;
  wish << turn, -model_.mass_kg * acceleration.dot(r.col(2));
  Eigen::VectorXd squares = to_squares_ * wish;
  const double most = model_.max_speed_rad_s * model_.max_speed_rad_s;
  limited_ = squares.minCoeff() < 0.0 || squares.maxCoeff() > most;
  squares = squares.cwiseMax(0.0);
  command.stamp_ns = state.stamp_ns;
  command.rotors = model_.rotors;
  for (std::uint32_t i = 0; i < model_.rotors; ++i) command.speed_rad_s[i] = std::sqrt(squares(i));
}

}  // namespace sortie::bench
