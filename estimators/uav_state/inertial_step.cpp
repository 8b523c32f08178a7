// SPDX-License-Identifier: BSD-3-Clause
// How the errors of dead reckoning grow.
#include "estimators/uav_state/inertial_step.hpp"

namespace sortie::estimators {
namespace {

struct Blocks {
  double force[9];  // velocity from attitude error: -R [f]x dt
  double bias[9];   // velocity from accelerometer bias: -R dt
  double turn[9];   // attitude error carried along: 1 - [w]x dt + ([w]x dt)^2 / 2
};

// One column (stride 15) or row (stride 1) of the covariance goes through F.
void apply(const Blocks& b, double dt_s, double* x, std::size_t stride) {
  double old[kErrorStates];
  for (std::size_t i = 0; i < kErrorStates; ++i) old[i] = x[i * stride];
  for (std::size_t i = 0; i < 3; ++i) {
    const double* force = b.force + 3 * i;
    const double* bias = b.bias + 3 * i;
    const double* turn = b.turn + 3 * i;
    const double dv = force[0] * old[6] + force[1] * old[7] + force[2] * old[8] + bias[0] * old[12] +
                      bias[1] * old[13] + bias[2] * old[14];
    x[i * stride] = old[i] + dt_s * (old[3 + i] + 0.5 * dv);
    x[(3 + i) * stride] = old[3 + i] + dv;
    x[(6 + i) * stride] = turn[0] * old[6] + turn[1] * old[7] + turn[2] * old[8] - dt_s * old[9 + i];
  }
}

}  // namespace

void propagate(ErrorCovariance& p, const InertialState& s, const InertialReading& r,
               const InertialNoise& noise) {
  const rt::Vector3 f = r.acc_m_s2 - s.acc_bias_m_s2;
  const rt::Vector3 w = r.dt_s * (r.gyr_rad_s - s.gyr_bias_rad_s);
  const rt::RotationMatrix rotation = rt::to_matrix(s.q_world_body);
  Blocks b{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double* row = rotation.m + 3 * i;
    // Row of R times [f]x.
    b.force[3 * i] = -r.dt_s * (row[1] * f.z - row[2] * f.y);
    b.force[3 * i + 1] = -r.dt_s * (row[2] * f.x - row[0] * f.z);
    b.force[3 * i + 2] = -r.dt_s * (row[0] * f.y - row[1] * f.x);
    for (std::size_t j = 0; j < 3; ++j) b.bias[3 * i + j] = -r.dt_s * row[j];
  }
  const double ww = rt::dot(w, w);
  const double wa[3] = {w.x, w.y, w.z};
  const double skew[9] = {0, w.z, -w.y, -w.z, 0, w.x, w.y, -w.x, 0};  // -[w]x
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double eye = i == j ? 1.0 : 0.0;
      b.turn[3 * i + j] = eye + skew[3 * i + j] + 0.5 * (wa[i] * wa[j] - ww * eye);
    }
  }
  for (std::size_t c = 0; c < kErrorStates; ++c) apply(b, r.dt_s, &p.m[c], kErrorStates);
  for (std::size_t row = 0; row < kErrorStates; ++row) apply(b, r.dt_s, &p.m[row * kErrorStates], 1);
  const double dt = r.dt_s;
  const double acc = noise.acc_m_s2_rt_hz * noise.acc_m_s2_rt_hz * dt;
  const double added[5] = {0.25 * acc * dt * dt, acc, noise.gyr_rad_s_rt_hz * noise.gyr_rad_s_rt_hz * dt,
                           noise.gyr_walk_rad_s_rt_s * noise.gyr_walk_rad_s_rt_s * dt,
                           noise.acc_walk_m_s2_rt_s * noise.acc_walk_m_s2_rt_s * dt};
  for (std::size_t i = 0; i < kErrorStates; ++i) p(i, i) += added[i / 3];
}

}  // namespace sortie::estimators
