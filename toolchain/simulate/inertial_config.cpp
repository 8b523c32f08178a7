// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/simulate/hil_config.hpp"

#include <algorithm>
#include <string>

#include "firmware_like/scene/units.hpp"

namespace sortie::toolchain {
namespace {

// `device` is "imu" or "encoder": hil.imu_jitter_us and so on.
void read_stream(firmware::Profile& profile, const std::string& device, std::uint32_t rate_hz,
                 hil::FaultConfig& faults) {
  const auto number = [&](const char* key, double high, const char* unit, const char* meaning) {
    return profile.number("hil." + device + key, {0, 0, high, unit, meaning});
  };
  faults.jitter_ns = 1e3 * number("_jitter_us", 1e5, "us", "sigma of the error of each stamp");
  const double per_min = number("_outages_per_min", 600, "1/min", "how often the device falls silent");
  faults.outage = std::min(1.0, per_min / (60.0 * static_cast<double>(rate_hz)));
  faults.outage_ns = firmware::milliseconds(number("_outage_ms", 60'000, "ms", "how long each time"));
}

void read_imu(firmware::Profile& profile, hil::ImuConfig& imu) {
  const auto number = [&profile](auto&&... key) { read_number(profile, key...); };
  number("hil.imu_hz", imu.rate_hz, 1, 1000, "Hz", "must divide 1000");
  const char* place = "where the IMU sits, from the body's origin (tracks: the ground point between them)";
  number("hil.imu_x_m", imu.lever_arm_m[0], -10, 10, "m", place);
  number("hil.imu_y_m", imu.lever_arm_m[1], -10, 10, "m", place);
  number("hil.imu_z_m", imu.lever_arm_m[2], -10, 10, "m", place);
  number("hil.gyr_noise_rad_s_rt_hz", imu.gyr_noise_rad_s_rt_hz, 0, 1, "rad/s/rtHz",
         "density of white noise");
  number("hil.acc_noise_m_s2_rt_hz", imu.acc_noise_m_s2_rt_hz, 0, 10, "m/s2/rtHz", "density of white noise");
  number("hil.gyr_bias_rad_s", imu.gyr_bias_rad_s, 0, 1, "rad/s", "sigma of the switch-on bias");
  number("hil.acc_bias_m_s2", imu.acc_bias_m_s2, 0, 10, "m/s2", "sigma of the switch-on bias");
  number("hil.gyr_walk_rad_s_rt_s", imu.gyr_walk_rad_s_rt_s, 0, 1, "rad/s/rts", "growth of the bias");
  number("hil.acc_walk_m_s2_rt_s", imu.acc_walk_m_s2_rt_s, 0, 10, "m/s2/rts", "growth of the bias");
  number("hil.gyr_range_rad_s", imu.gyr_range_rad_s, 0.1, 16.3835, "rad/s", "axes clip here");
  number("hil.acc_range_m_s2", imu.acc_range_m_s2, 1, 163.835, "m/s2", "axes clip here");
  number("hil.imu_loss", imu.loss, 0, 1, "", "share of samples that are not delivered");
}

}  // namespace

void read_imu_alone(firmware::Profile& profile, hil::ImuConfig& imu, hil::FaultConfig& faults) {
  read_imu(profile, imu);
  faults.saturate = profile.number("hil.imu_saturate", {0, 0, 1, "", "share of samples with a clipped axis"});
  read_stream(profile, "imu", imu.rate_hz, faults);
}

void read_inertial(firmware::Profile& profile, hil::UgvConfig& config) {
  read_imu_alone(profile, config.imu, config.imu_faults);
  hil::EncoderConfig& encoder = config.encoder;
  read_number(profile, "hil.encoder_hz", encoder.rate_hz, 1, 1000, "Hz", "must divide 1000");
  read_number(profile, "hil.encoder_resolution_m", encoder.resolution_m, 1e-6, 0.1, "m", "travel per count");
  encoder.scale_left =
      profile.number("hil.encoder_scale_left", {1, 0.5, 2, "", "shown travel / true travel of the belt"});
  encoder.scale_right =
      profile.number("hil.encoder_scale_right", {1, 0.5, 2, "", "shown travel / true travel of the belt"});
  config.track_faults.drop =
      profile.number("hil.encoder_loss", {0, 0, 1, "", "share of encoder messages that are not sent"});
  read_stream(profile, "encoder", encoder.rate_hz, config.track_faults);
}

}  // namespace sortie::toolchain
