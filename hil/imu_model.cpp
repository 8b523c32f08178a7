// SPDX-License-Identifier: BSD-3-Clause
// IMU error model.
#include "hil/imu_model.hpp"

#include <algorithm>
#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr std::uint64_t kStream = 0x696d75;

double clip(double value, double range, bool& clipped) {
  clipped = clipped || std::fabs(value) >= range;
  return std::clamp(value, -range, range);
}

void store(const Vec3& v, double range, double out[3], bool& clipped) {
  out[0] = clip(v.x, range, clipped);
  out[1] = clip(v.y, range, clipped);
  out[2] = clip(v.z, range, clipped);
}

bool not_negative(double value) { return std::isfinite(value) && value >= 0.0; }

}  // namespace

ImuModel::ImuModel(const ImuConfig& config, std::uint64_t seed) : config_(config), random_(seed, kStream) {
  require("imu", config.rate_hz > 0 && config.rate_hz <= 1000 && 1000 % config.rate_hz == 0,
          "rate_hz must divide 1000");
  require("imu",
          not_negative(config.gyr_noise_rad_s_rt_hz) && not_negative(config.acc_noise_m_s2_rt_hz) &&
              not_negative(config.gyr_bias_rad_s) && not_negative(config.acc_bias_m_s2) &&
              not_negative(config.gyr_walk_rad_s_rt_s) && not_negative(config.acc_walk_m_s2_rt_s),
          "noise, bias and walk must be finite and not negative");
  require("imu", config.gyr_range_rad_s > 0.0 && config.acc_range_m_s2 > 0.0, "the ranges must be above 0");
  require("imu", config.loss >= 0.0 && config.loss <= 1.0, "loss must lie in 0..1");
  const double root_rate = std::sqrt(static_cast<double>(config.rate_hz));
  gyr_sigma_ = config.gyr_noise_rad_s_rt_hz * root_rate;
  acc_sigma_ = config.acc_noise_m_s2_rt_hz * root_rate;
  gyr_step_ = config.gyr_walk_rad_s_rt_s / root_rate;
  acc_step_ = config.acc_walk_m_s2_rt_s / root_rate;
  gyr_bias_ = draw(config.gyr_bias_rad_s);
  acc_bias_ = draw(config.acc_bias_m_s2);
}

Vec3 ImuModel::draw(double sigma) {
  const double x = random_.normal();
  const double y = random_.normal();
  const double z = random_.normal();
  return {sigma * x, sigma * y, sigma * z};
}

bool ImuModel::read(const InertialTruth& truth, rt::Nanoseconds stamp_ns, rt::ImuSample& sample) {
  const Vec3 gyr_noise = draw(gyr_sigma_);
  const Vec3 acc_noise = draw(acc_sigma_);
  gyr_bias_ = gyr_bias_ + draw(gyr_step_);
  acc_bias_ = acc_bias_ + draw(acc_step_);
  const bool lost = random_.chance(config_.loss);
  bool gyr_clipped = false;
  bool acc_clipped = false;
  sample.stamp_ns = stamp_ns;
  store(truth.gyr_rad_s + gyr_bias_ + gyr_noise, config_.gyr_range_rad_s, sample.gyr_rad_s, gyr_clipped);
  store(truth.acc_m_s2 + acc_bias_ + acc_noise, config_.acc_range_m_s2, sample.acc_m_s2, acc_clipped);
  sample.flags = rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate;
  if (gyr_clipped || acc_clipped) {
    sample.flags |= rt::kImuSaturated | (gyr_clipped ? 0u : +rt::kImuOnlyAccSaturated);
    ++clipped_;
  }
  if (lost) ++lost_;
  return !lost;
}

}  // namespace sortie::hil
