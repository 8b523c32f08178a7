// SPDX-License-Identifier: BSD-3-Clause
// Attitude from an inertial sensor: a complementary filter on true time stamps, with gyro bias.
#pragma once

#include <cstdint>

#include "rt/archive.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/stamp_gate.hpp"
#include "rt/status.hpp"

namespace sortie::estimators {

/// Bits of rt::AttitudeEstimate::flags.
enum AttitudeFlags : std::uint32_t {
  kAttitudeStarted = 1u,     ///< at least one sample was used
  kAttitudeLevelled = 2u,    ///< roll and pitch come from the accelerometer (else from the configuration)
  kAttitudeAtRest = 4u,      ///< the sensor stands still; the gyro bias is being read off
  kAttitudeCoasted = 8u,     ///< the newest step bridged a gap with a held rate
  kAttitudeSaturated = 16u,  ///< the newest sample was clipped by the device
  kAttitudeHeadingInvalid =
      32u,  ///< a clipped or lost stretch was integrated: heading is off by an unknown angle
};

/// Settings of the attitude filter. The defaults serve small robots at 20 Hz to 1 kHz.
struct AttitudeConfig {
  /// Attitude at the first sample. The accelerometer replaces roll and pitch; heading stays.
  double q_world_body[4]{1, 0, 0, 0};
  double bias_rad_s[3]{};              ///< gyro bias at the first sample
  double acc_time_constant_s{2.0};     ///< low-pass of the specific force in the world frame
  double inclination_gain_per_s{0.4};  ///< proportional part: share of the tilt error removed in a second
  double bias_gain_per_s2{0.004};      ///< integral part: tilt error to gyro bias; 0 switches it off
  double rest_bias_gain_per_s{0.5};    ///< gyro mean to bias while at rest; 0 switches it off
  double max_bias_rad_s{0.035};        ///< the bias is held within this; also the fastest turn taken for rest
  double acc_innovation_limit_m_s2{40.0};  ///< one sample counts no more than this far from the mean
  double rest_rate_rad_s{0.035};           ///< rest: gyro stays this close to its mean
  double rest_acc_m_s2{0.5};               ///< rest: accelerometer stays this close to its mean
  double rest_time_s{1.5};                 ///< rest: for so long
  double max_rate_rad_s{100.0};            ///< a faster reading is no reading
  double max_acc_m_s2{800.0};              ///< a larger reading is no reading
  rt::Nanoseconds max_coast_ns{500 *
                               rt::kNanosecondsPerMillisecond};  ///< longest gap bridged with a held rate
  rt::Nanoseconds max_step_ns{10 * rt::kNanosecondsPerSecond};   ///< a longer step of time is doubted
};

/// What happened to the samples, since start. used + the refusals = all samples given.
struct AttitudeCounters {
  std::uint64_t used{};
  std::uint64_t not_finite{};
  std::uint64_t out_of_range{};  ///< too large, all zero, or without a gyro reading
  std::uint64_t time_backwards{};
  std::uint64_t time_repeated{};
  std::uint64_t time_jumped{};  ///< too far ahead
  std::uint64_t gaps{};         ///< used samples that ended a gap longer than max_coast_ns
  std::uint64_t resumed{};      ///< used samples that began a new time line
  std::uint64_t saturated{};    ///< used samples that the device had clipped

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("used", self.used);
    visit("not_finite", self.not_finite);
    visit("out_of_range", self.out_of_range);
    visit("time_backwards", self.time_backwards);
    visit("time_repeated", self.time_repeated);
    visit("time_jumped", self.time_jumped);
    visit("gaps", self.gaps);
    visit("resumed", self.resumed);
    visit("saturated", self.saturated);
  }
};

/// Complementary filter: gyro strapdown by the exponential map (two-sample coning correction), inclination
/// and bias by a PI loop on the specific force, which is low-passed in the world frame, where the
/// accelerations of a robot that stays somewhere average out. Gyro-only samples are integrated as they are:
/// with kImuMeanRate the sum of the heading increments is the sum of the inputs. About 600 bytes; no heap;
/// bounded time. A sample that is refused changes nothing but a counter.
class Attitude {
 public:
  explicit Attitude(const AttitudeConfig& config);

  /// Takes one sample. `ok`, or the reason of the refusal: not_finite, out_of_range, time_backwards,
  /// time_repeated.
  Status update(const rt::ImuSample& sample);

  /// Tells what the sensor cannot know: that the robot moves (its tracks turn). A slow steady turn looks like
  /// a gyro bias at rest; while `moving` nothing is taken for rest. False until told otherwise.
  void set_moving(bool moving) { moving_ = moving; }

  /// Other gains from the next sample on; the state stays. The caller keeps them finite and not negative.
  void set_inclination_gain(double per_s) { config_.inclination_gain_per_s = per_s; }
  void set_bias_gain(double per_s2) { config_.bias_gain_per_s2 = per_s2; }

  /// The estimate after the newest sample that was used; the configured attitude before the first.
  const rt::AttitudeEstimate& estimate() const { return estimate_; }
  const AttitudeCounters& counters() const { return counters_; }

  /// State to bytes and back, into a filter of the same configuration.
  void archive(rt::Archive& archive);

 private:
  Status check(const rt::ImuSample& sample);
  double step_seconds(const rt::ImuSample& sample, rt::Nanoseconds last_stamp_ns);
  void integrate(const rt::ImuSample& sample, double dt_s);
  void level(const rt::Vector3& acc_body);
  void correct(const rt::Vector3& acc_body, double dt_s);
  void watch_rest(const rt::ImuSample& sample, double dt_s);
  void limit_bias();
  void publish(const rt::ImuSample& sample);

  AttitudeConfig config_;
  rt::StampGate gate_;
  rt::Quaternion q_world_body_;
  rt::Vector3 bias_;
  rt::Vector3 force_world_;  ///< low-passed specific force
  rt::Vector3 last_rate_;    ///< raw gyro reading of the last used sample
  rt::Vector3 mean_rate_;    ///< for the detection of rest
  rt::Vector3 mean_acc_;
  double last_step_s_{};  ///< interval that last_rate_ is the mean of
  double levelled_s_{};   ///< time since levelling: a young mean is averaged, not low-passed
  double rest_s_{};
  double delta_heading_rad_{};
  bool levelled_{};
  bool coasted_{};
  bool moving_{};
  bool heading_invalid_{};
  AttitudeCounters counters_;
  rt::AttitudeEstimate estimate_;
};

}  // namespace sortie::estimators
