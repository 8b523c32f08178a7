// SPDX-License-Identifier: BSD-3-Clause
// Settings, flags and counters of the attitude filter: everything that can be chosen, in one place.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::estimators {

/// Bits of rt::AttitudeEstimate::flags.
enum AttitudeFlags : std::uint32_t {
  kAttitudeStarted = 1u,     ///< at least one sample was used
  kAttitudeLevelled = 2u,    ///< roll and pitch come from the accelerometer (else from the configuration)
  kAttitudeAtRest = 4u,      ///< the sensor stands still; the gyro bias is being read off
  kAttitudeCoasted = 8u,     ///< the newest step bridged a gap with a held rate
  kAttitudeSaturated = 16u,  ///< the newest sample was clipped by the device
  kAttitudeHeadingInvalid = 32u,  ///< a clipped, lost or dead stretch lies in the heading; see set_heading()
  kAttitudeAided = 64u,           ///< the tracks' acceleration is taken out of the specific force
  kAttitudeAidRefused = 128u,     ///< the tracks and the accelerometer disagree (slip): no aid at present
  kAttitudeStands = 256u,         ///< tracks and sensor stand still: the heading is held
};

/// What one inertial sample stands for. Rates: coning correction and bridging of gaps depend on it.
enum class ImuValues : std::uint8_t {
  as_flagged,  ///< as rt::kImuMeanRate of each sample says
  means,       ///< means over the interval before the stamp, whatever the flag says
  points,      ///< points in time, whatever the flag says
};

/// Settings of the attitude filter. The defaults serve 20 Hz to 1 kHz; those of the inclination and of the
/// bias are the published ones of VQF (Laidig, Seel 2023), which fit many sensors, not the best of one.
struct AttitudeConfig {
  /// Attitude at the first sample. The accelerometer replaces roll and pitch; heading stays.
  double q_world_body[4]{1, 0, 0, 0};
  double bias_rad_s[3]{};                    ///< gyro bias at the first sample
  ImuValues samples{ImuValues::as_flagged};  ///< sample kind
  /// The device sums up until it is heard: a mean covers all the time since the sample before, however long.
  /// Otherwise, in a stream of even steps, a mean covers the usual step, and what is missing is bridged.
  /// Uneven steps, and those of a gyro without accelerometer, are always taken as covered.
  bool means_cover_gaps{false};
  bool coning{true};  ///< false: the rate is taken to keep its direction over two samples
  /// Samples are gathered for so long before the accelerometer, the rest detector and the bias are looked at:
  /// their time constants are 10 to 1000 times longer. Slower sensors do so at each sample.
  rt::Nanoseconds block_ns{35 * rt::kNanosecondsPerMillisecond};

  double acc_time_constant_s{3.0};   ///< low-pass of the specific force in the world frame
  double acc_deviation_m_s2{15.0};   ///< one sample counts no more than this from the mean force, ...
  double acc_deviation_factor{2.0};  ///< ... plus so many mean deviations: lasting motion opens the limit
  double acc_bias_m_s2{0.05};        ///< 1 sigma of the accelerometer's own error, for the covariance only

  double bias_sigma_initial_rad_s{0.0087266};  ///< 1 sigma at start (0.5 deg/s); 0: no bias filter
  double bias_sigma_motion_rad_s{0.0017453};   ///< steady 1 sigma in motion (0.1 deg/s): low learns slowly
  double bias_sigma_rest_rad_s{0.00052360};    ///< steady 1 sigma at rest (0.03 deg/s)
  double bias_forgetting_s{100.0};             ///< in which the bias walks by 0.1 deg/s, 1 sigma
  double max_bias_rad_s{0.035};     ///< the bias is held within this; also the fastest turn taken for rest
  bool heading_follows_bias{true};  ///< a bias learned late also turns back what it did to the heading, ...
  double heading_payment_rad_s{0.0087};  ///< ... once the robot moves, at most so fast (0.5 deg/s)
  double gyr_noise_rad_s_rthz{0.0002};   ///< white noise of the gyro: for the covariance, and against ...
  double bias_walk_rad_s_rts{1e-5};      ///< ... this drift of the bias: what a rest is worth to the heading

  double rest_rate_rad_s{0.035};  ///< rest: gyro stays this close to its mean
  double rest_acc_m_s2{0.5};      ///< rest: accelerometer stays this close to its mean
  double rest_mean_s{0.5};        ///< rest: time constant of these means
  double rest_time_s{1.5};        ///< rest: for so long

  double max_rate_rad_s{200.0};      ///< a faster reading is no reading
  double max_acc_m_s2{800.0};        ///< a larger reading is no reading
  std::uint32_t max_zero_rates{16};  ///< all-zero gyro readings in motion refused in a row; then believed
  /// Longest gap bridged with a held rate (point samples; a mean covers its interval however long that is).
  rt::Nanoseconds max_coast_ns{500 * rt::kNanosecondsPerMillisecond};
  rt::Nanoseconds max_step_ns{10 * rt::kNanosecondsPerSecond};  ///< a longer step of time is doubted
  double gyr_range_rad_s{0};        ///< the device clips at this; 0: only its flag tells
  double clipped_rate_rad_s{10.0};  ///< 1 sigma of what a clipped gyro reading may lack
  double relevel_rad{0.1};          ///< inclination is averaged afresh when this much turn may be unknown

  double p_body_imu_m[3]{};  ///< lever arm: the sensor seen from the point whose speed the tracks tell
  rt::Nanoseconds max_aid_age_ns{200 * rt::kNanosecondsPerMillisecond};  ///< an older speed is no aid
  double aid_window_s{1.0};           ///< over which tracks and accelerometer are compared
  double aid_disagreement_m_s2{0.4};  ///< the tracks' acceleration may explain so much worse than none

  SORTIE_KEYS(c, key) {
    key("acc_time_constant_s", c.acc_time_constant_s,
        {0.01, 100, "s", "low-pass of the specific force in the world frame", rt::kKnob},
        [](auto& filter, double value) { return filter.set_acc_time_constant(value), Status::ok; });
    key("bias_sigma_rad_s", c.bias_sigma_initial_rad_s,
        {0, 1, "rad/s", "sigma of the gyro bias at start; 0: no bias filter", rt::kKnob});
    key("bias_forgetting_s", c.bias_forgetting_s,
        {1, 1e6, "s", "in which the gyro bias walks by 0.1 deg/s, 1 sigma", rt::kKnob},
        [](auto& filter, double value) { return filter.set_bias_forgetting(value), Status::ok; });
    key("block_ms", c.block_ns,
        {0.001, 1000, rt::kMsInNs, "between looks at the accelerometer, the bias and rest", rt::kKnob});
    constexpr const char* kArm = "place of the IMU, seen from the point whose speed the tracks tell";
    key("imu.x_m", c.p_body_imu_m[0], {-10, 10, "m", kArm});
    key("imu.y_m", c.p_body_imu_m[1], {-10, 10, "m", kArm});
    key("imu.z_m", c.p_body_imu_m[2], {-10, 10, "m", kArm});
    key("max_rate_rad_s", c.max_rate_rad_s, {0.1, 1e4, "rad/s", "a faster reading is no reading"});
    key("max_coast_ms", c.max_coast_ns, {1, 1e5, rt::kMsInNs, "longest gap bridged with a held rate"});
  }
};

/// What happened to the samples, since start. used + the refusals = all samples given.
struct AttitudeCounters {
  std::uint64_t used{};
  std::uint64_t not_finite{};
  std::uint64_t out_of_range{};  ///< too large, six zeros, or without a gyro reading
  std::uint64_t zero_rate{};     ///< an all-zero gyro reading in motion
  std::uint64_t time_backwards{};
  std::uint64_t time_repeated{};
  std::uint64_t time_jumped{};  ///< too far ahead
  std::uint64_t gaps{};         ///< used samples that ended a gap longer than max_coast_ns
  std::uint64_t resumed{};      ///< used samples that began a new time line
  std::uint64_t saturated{};    ///< used samples that the device had clipped
  std::uint64_t shortened{};    ///< used samples whose specific force was beyond the limit
  std::uint64_t aid_refused{};  ///< times that the tracks lost trust
  SORTIE_FIELDS(used, not_finite, out_of_range, zero_rate, time_backwards, time_repeated, time_jumped, gaps,
                resumed, saturated, shortened, aid_refused)
};

}  // namespace sortie::estimators
