// SPDX-License-Identifier: BSD-3-Clause
// Where a UAV is and how it moves, from an inertial sensor and late fixes of position and heading.
#pragma once

#include <array>
#include <cstdint>

#include "estimators/uav_state/disturbance_observer.hpp"
#include "estimators/uav_state/inertial_step.hpp"
#include "estimators/uav_state/refused_run.hpp"
#include "rt/archive.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/stamp_gate.hpp"
#include "rt/status.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::estimators {

/// Settings of the estimator.
struct UavEstimatorConfig {
  InertialNoise noise;
  double gravity_m_s2{9.81};
  rt::Vector3 p_body_imu_m;   ///< where the sensor sits, from the body's origin; its axes are the body's
  double fix_sigma_m{0.012};  ///< of a fix, each axis
  double fix_yaw_sigma_rad{0.012};
  double start_velocity_sigma_m_s{0.05};
  double start_tilt_sigma_rad{0.008};
  double start_gyr_bias_sigma_rad_s{0.004};
  double start_acc_bias_sigma_m_s2{0.04};
  double level_s{0.25};  ///< at rest at the start, for levelling and the gyro's bias
  double gate{25.0};     ///< squared Mahalanobis distance of a fix that is still believed
  double yaw_gate{16.0};
  double dead_after_s{0.3};         ///< without a fix: dead reckoning
  double lost_after_s{3.0};         ///< and lost
  double lost_sigma_m{0.5};         ///< also lost: standard deviation of the position, worst axis
  std::uint32_t relocate_after{8};  ///< refused places (or headings) in a row that agree with each other
  double relocate_spread_m{0.3};    ///< so near are they, from one to the next: as places, or as seen from
                                    ///< the way that is reckoned
  double relocate_spread_rad{0.1};  ///< and headings, as seen from the heading that is reckoned
  double max_gap_s{0.05};           ///< longest interval of the inertial sensor that is integrated as it is
  double max_rate_rad_s{40.0};      ///< a larger reading is no reading
  double max_acc_m_s2{400.0};
  DisturbanceConfig disturbance;

  SORTIE_KEYS(c, key) {
    key("fix_sigma_m", c.fix_sigma_m, {1e-4, 10, "m", "of a fix, each axis", rt::kKnob});
    key("fix_yaw_sigma_rad", c.fix_yaw_sigma_rad, {1e-4, 1, "rad", "of a fix's heading", rt::kKnob});
    constexpr const char* kDensity = "density that the filter reckons with";
    key("gyr_noise_rad_s_rt_hz", c.noise.gyr_rad_s_rt_hz, {1e-6, 1, "rad/s/rtHz", kDensity, rt::kKnob});
    key("acc_noise_m_s2_rt_hz", c.noise.acc_m_s2_rt_hz, {1e-5, 10, "m/s2/rtHz", kDensity, rt::kKnob});
    constexpr const char* kArm = "where the IMU sits, from the body's origin";
    key("imu.x_m", c.p_body_imu_m.x, {-10, 10, "m", kArm});
    key("imu.y_m", c.p_body_imu_m.y, {-10, 10, "m", kArm});
    key("imu.z_m", c.p_body_imu_m.z, {-10, 10, "m", kArm});
    key("dead_after_s", c.dead_after_s, {0.05, 10, "s", "without a fix: dead reckoning, it hovers"});
    key("lost_after_s", c.lost_after_s, {0.1, 60, "s", "without a fix: lost, it sinks level"});
    key("lost_sigma_m", c.lost_sigma_m, {0.05, 100, "m", "also lost: standard deviation of the worst axis"});
    key("disturbance_hz", c.disturbance.across_hz,
        {0.1, 50, "Hz", "bandwidth of the observed wind, square to the rotors' axis", rt::kKnob});
  }
};

/// What happened to the samples, since start. fixes_used + fixes_refused + fixes_gated = all fixes given.
struct UavEstimatorCounters {
  std::uint64_t imu_used{};
  std::uint64_t imu_refused{};
  std::uint64_t imu_gaps{};
  std::uint64_t fixes_used{};     ///< the place, the heading, or both
  std::uint64_t fixes_refused{};  ///< say nothing, not finite, or of a time that is gone or not yet there
  std::uint64_t fixes_gated{};    ///< too far from what is believed: nothing of them was used
  std::uint64_t yaws_gated{};     ///< headings too far from what is believed, also of fixes that were used
  std::uint64_t relocated{};      ///< gave in to places that agreed
  std::uint64_t reheaded{};       ///< gave in to headings that agreed
  SORTIE_FIELDS(imu_used, imu_refused, imu_gaps, fixes_used, fixes_refused, fixes_gated, yaws_gated,
                relocated, reheaded)
};

/// Error-state Kalman filter of 15 states. Two copies of it run: one stands at the stamp of the newest fix,
/// the other goes ahead with each reading. A late fix moves the first on to its stamp over the readings kept
/// since, corrects it there, and the second starts from it anew: what comes out is exactly what a filter
/// would say that had had the fix in time. Readings are kept for kHistory intervals; older fixes are refused,
/// so is one that is older than another that was used. A fix that is refused leaves no trace but counters and
/// its place in the run of refused ones. A reading more than 10 s ahead, or back in time, is
/// refused; eight in a row that follow each other are believed, and everything begins anew, with levelling.
///
/// Place and heading of a fix are two measurements with a gate each; what a fix does not carry is not read.
/// Neither gate stays shut: to relocate_after refused places that agree the position gives in (its velocity
/// comes from them, too; attitude and biases stay), to as many headings the heading. Headings that do not
/// agree make the verdict dead and lost as missing places do.
/// 15 kB, no heap. A reading costs about 1.5 us, a fix at most 2 kHistory readings.
class UavEstimator {
 public:
  static constexpr std::uint32_t kHistory = 128;

  explicit UavEstimator(const UavEstimatorConfig& config);

  /// One reading (body frame), with the collective acceleration along the body's z that the rotors are
  /// expected to make in its interval. ok; not_finite, out_of_range, time_repeated or time_backwards: nothing
  /// changes but a counter.
  Status imu(const rt::ImuSample& sample, double thrust_m_s2);
  /// One fix, whenever it arrives. ok (some of it was used); not_finite (of what it carries); stale (older
  /// than what is kept or used); out_of_range (ahead of the readings, or gated); empty (carries nothing, not
  /// levelled yet, a first one without place or heading, or only a heading where the nose points up or down).
  Status fix(const rt::UavFix& fix);

  /// After the newest reading.
  const rt::UavState& state() const { return state_; }
  const InertialState& now() const { return now_; }
  const ErrorCovariance& covariance() const { return now_p_; }
  const UavEstimatorCounters& counters() const { return counters_; }

  /// State to bytes and back, into an estimator of the same configuration.
  void archive(rt::Archive& archive);

 private:
  Status check(const rt::ImuSample& sample) const;
  Status check_time(rt::Nanoseconds stamp_ns);
  void level(const InertialReading& reading);
  void move_to_origin(InertialReading& reading) const;
  rt::Quaternion move(InertialState& state, ErrorCovariance& p, const InertialReading& reading) const;
  void advance_base();
  void restart_now();
  // The base and the readings after it, to come back to.
  struct Mark {
    InertialState base;
    ErrorCovariance base_p;
    rt::Nanoseconds base_ns;
    std::uint32_t first;
    std::uint32_t count;
  };
  Mark mark() const { return {base_, base_p_, base_ns_, first_, count_}; }
  void back_to(const Mark& mark);
  // How a heading looks from the base: its error per error of the attitude, and how far off it is.
  struct HeadingSeen {
    double h[kErrorStates]{};
    double off_rad{};
    bool defined{};  ///< false: the nose points up or down, or the fix carries none; the rest is not there
    bool fits{};     ///< the gate believes it
  };

  Status admit(const rt::UavFix& fix) const;
  Status correct_or_undo(const rt::UavFix& fix);
  void forget(std::size_t from, std::size_t to, double variance);
  void begin(const rt::UavFix& fix);
  Status correct(const rt::UavFix& fix, double ahead_s);
  bool correct_place(const rt::UavFix& fix, double ahead_s, double (&dx)[kErrorStates]);
  bool correct_heading(const rt::UavFix& fix, const HeadingSeen& seen, double (&dx)[kErrorStates]);
  HeadingSeen see_heading(const rt::UavFix& fix) const;
  void scalar(const double (&h)[kErrorStates], double innovation, double variance,
              double (&dx)[kErrorStates]);
  void inject(const double (&dx)[kErrorStates]);
  bool agreed_place(rt::Nanoseconds stamp_ns, const rt::Vector3& at, const rt::Vector3& off);
  bool note_heading(rt::Nanoseconds stamp_ns, const HeadingSeen& seen);
  void relocate(const rt::UavFix& fix, const rt::Vector3& off, double ahead_s);
  void turn_to(const rt::UavFix& fix);
  void judge();
  void publish(const rt::Vector3& w);

  UavEstimatorConfig config_;
  DisturbanceObserver observer_;
  InertialState base_;
  InertialState now_;
  ErrorCovariance base_p_;
  ErrorCovariance now_p_;
  std::array<InertialReading, kHistory> readings_{};  ///< from base to now
  std::array<rt::Nanoseconds, kHistory> stamps_{};    ///< of their ends
  std::uint32_t first_{};
  std::uint32_t count_{};
  rt::StampGate gate_{10 * rt::kNanosecondsPerSecond};
  rt::Nanoseconds base_ns_{};
  rt::Nanoseconds now_ns_{};
  rt::Nanoseconds last_fix_ns_{};
  bool have_imu_{};
  bool levelled_{};
  bool located_{};
  double level_time_s_{};
  rt::Vector3 level_acc_;
  rt::Vector3 level_gyr_;
  RefusedRun places_;  ///< refused ones
  rt::Vector3 refused_at_m_;
  rt::Vector3 refused_off_m_;        ///< from where the base was then
  rt::Vector3 refused_first_off_m_;  ///< of the first of those that agree
  RefusedRun headings_;              ///< refused ones
  double refused_off_rad_{};
  UavEstimatorCounters counters_;
  rt::UavState state_;
};

}  // namespace sortie::estimators
