// SPDX-License-Identifier: BSD-3-Clause
// Errors of a simulated IMU: biases that wander, white noise, a limited range and lost samples.
#pragma once

#include <cstdint>

#include "hil/imu_truth.hpp"
#include "hil/random.hpp"
#include "rt/samples.hpp"

namespace sortie::hil {

/// The device. Noise defaults are those of an ADIS16448; a zero switches an error off.
struct ImuConfig {
  std::uint32_t rate_hz{200};            ///< must divide 1000
  double lever_arm_m[3]{0.0, 0.0, 0.0};  ///< place on the body, from the ground point between the tracks
  double gyr_noise_rad_s_rt_hz{3.4e-4};  ///< density of the white noise, rad/s per square root of Hz
  double acc_noise_m_s2_rt_hz{4e-3};
  double gyr_bias_rad_s{0.002};  ///< standard deviation of the bias at switch-on, each axis
  double acc_bias_m_s2{0.02};
  double gyr_walk_rad_s_rt_s{1e-5};  ///< growth of the bias per square root of a second
  double acc_walk_m_s2_rt_s{1e-4};
  double gyr_range_rad_s{16.3835};  ///< default ranges: of the CAN frames, which mark clipped axes
  double acc_range_m_s2{163.835};
  double loss{0.0};  ///< share of samples that the device does not deliver
};

/// Turns true rates and forces into readings. Deterministic by seed; the draws per sample do not depend on
/// what is lost or clipped. No heap. Cost: about 0.4 us a sample.
class ImuModel {
 public:
  /// Throws std::runtime_error naming the setting if the config is not usable.
  ImuModel(const ImuConfig& config, std::uint64_t seed);

  /// One reading at the end of the interval that `truth` is the mean of. Flags: gyr, acc, mean rate, and
  /// saturated if an axis was clipped. False: the device lost it; it is not to be sent.
  bool read(const InertialTruth& truth, rt::Nanoseconds stamp_ns, rt::ImuSample& sample);

  /// Between two readings.
  rt::Nanoseconds period_ns() const {
    return rt::kNanosecondsPerSecond / static_cast<rt::Nanoseconds>(config_.rate_hz);
  }
  /// Present biases, for judging an estimator.
  const Vec3& gyr_bias_rad_s() const { return gyr_bias_; }
  const Vec3& acc_bias_m_s2() const { return acc_bias_; }
  /// Samples that the device lost.
  std::uint64_t lost() const { return lost_; }
  /// Samples with a clipped axis.
  std::uint64_t clipped() const { return clipped_; }

 private:
  Vec3 draw(double sigma);

  ImuConfig config_;
  Random random_;
  Vec3 gyr_bias_;
  Vec3 acc_bias_;
  double gyr_sigma_{};
  double acc_sigma_{};
  double gyr_step_{};
  double acc_step_{};
  std::uint64_t lost_{};
  std::uint64_t clipped_{};
};

}  // namespace sortie::hil
