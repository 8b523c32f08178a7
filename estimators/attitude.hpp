// SPDX-License-Identifier: BSD-3-Clause
// Attitude from an inertial sensor on true time stamps, with gyro bias and the tracks' speed.
#pragma once

#include <cstdint>
#include <limits>

#include "estimators/attitude_config.hpp"
#include "estimators/gyro_bias.hpp"
#include "estimators/heading_hold.hpp"
#include "estimators/real_rotation.hpp"
#include "estimators/slow_value.hpp"
#include "estimators/track_aid.hpp"
#include "rt/archive.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/stamp_gate.hpp"
#include "rt/status.hpp"

namespace sortie::estimators {

/// Strapdown of the gyro by the exponential map with coning correction; inclination from the specific force,
/// low-passed in the world frame, where the accelerations of a robot that stays somewhere average out; gyro
/// bias by a Kalman filter from the corrections that the inclination needs and from rest. The structure is
/// that of VQF (Laidig, Seel: Information Fusion 91, 2023). What is ours: steps of any length, slow parts in
/// blocks of samples (a third of the work), limits that open by themselves, the tracks' acceleration,
/// covariance, and every check before the state. Gyro-only samples are integrated as they are: with means the
/// sum of the heading increments is the sum of the inputs. `Real` is float or double; heading increments are
/// summed in double. 1.6 kB in double; no heap; bounded time. A refused sample changes nothing but a counter.
template <class Real>
class BasicAttitude {
 public:
  explicit BasicAttitude(const AttitudeConfig& config);

  /// Takes one sample. `ok`, or the reason of the refusal: not_finite, out_of_range, time_backwards,
  /// time_repeated. In a stream of even steps a sample that comes much later than the next should is held,
  /// with `ok`: the next one tells whether it is used (a gap) or refused (a wild stamp), and until then the
  /// estimate stays. About 230 floating point operations, and 600 more at the end of a block.
  Status update(const rt::ImuSample& sample);

  /// Tells what the sensor cannot know: that the robot moves (a track turns, on the spot, too) or that it
  /// stands. A slow steady turn looks like a gyro bias at rest; while `moving` nothing is taken for rest.
  /// Where tracks stand as well, the heading stands with the first quiet block, else after rest_time_s. Told
  /// once or at every sample is the same.
  void set_moving(bool moving) {
    moving_ = moving;
    told_ = true;
    block_.restless = block_.restless || moving;
  }

  /// Tells the velocity of the body's origin, body axes, at `stamp_ns` on the sensor's clock: the
  /// acceleration that follows from it is taken out of the specific force. On an edge the body does not move
  /// along its own axis: give all of it. `not_finite` and `out_of_range` (beyond 100 m/s, or a stamp beyond
  /// 73 years) change nothing. An aid that is not renewed ends by itself.
  Status set_track_velocity(const rt::Vector3& v_body_m_s, rt::Nanoseconds stamp_ns);

  /// The same of a body that moves along its x axis alone.
  Status set_track_speed(double speed_m_s, rt::Nanoseconds stamp_ns) {
    return set_track_velocity({speed_m_s, 0.0, 0.0}, stamp_ns);
  }

  /// The heading comes from elsewhere (a map, a fix): turns the attitude about the vertical and makes the
  /// heading valid, with this 1 sigma, a turn at most. delta_heading_rad goes on counting turns only.
  /// `not_finite` changes nothing.
  Status set_heading(double heading_rad, double sigma_rad);

  /// Other time constants from the next sample on; the state stays. The caller keeps them finite and above 0.
  void set_acc_time_constant(double seconds) { config_.acc_time_constant_s = seconds; }
  void set_bias_forgetting(double seconds) { config_.bias_forgetting_s = seconds; }

  /// The estimate after the newest sample that was used; the configured attitude before the first.
  const rt::AttitudeEstimate& estimate() const { return estimate_; }
  const AttitudeCounters& counters() const { return counters_; }

  /// Covariance of the attitude's error as a rotation vector in the world (x, y: inclination, z: heading
  /// since start), row-major, rad^2. As of the last block. The inclination's part is read off the corrections
  /// that the accelerometer asked for, so that it follows the accelerations; inclination and heading are
  /// taken as independent.
  void covariance(double (&out)[9]) const;

  /// State to bytes and back, into a filter of the same configuration and precision.
  void archive(rt::Archive& archive);

 private:
  using Vector = VectorOf<Real>;
  /// So many even steps make a stream whose wide steps are gaps.
  static constexpr std::uint32_t kEvenSteps = 16;

  // What gathers up to the end of a block.
  struct Block {
    Vector rate, away, body_force, row_x, row_y;  // each times its step; away: force less the mean force
    Vector cut;                                   // what shortening took from away
    Real time_s{}, force_s{};
    Real heading{};  // by how much the gyro turned it
    bool restless{};
    SORTIE_FIELDS(rate, away, cut, body_force, row_x, row_y, time_s, force_s, heading, restless)
  };

  Status check(const rt::ImuSample& sample);
  bool refuse_zero_rate();
  Status refuse(Status status, const rt::ImuSample& sample);
  bool is_wide_step(rt::Nanoseconds stamp_ns) const;
  Status take(const rt::ImuSample& sample);
  void note_step(rt::Nanoseconds step_ns);
  Real integrate(const rt::ImuSample& sample, rt::Nanoseconds step_ns);
  Vector turn_of_points(const Vector& now, const Vector& before, Real dt_s) const;
  Vector turn_of_means(const Vector& now, const Vector& before, Real dt_s, bool bridge) const;
  void turn_by(const Vector& phi);
  void add_change(const QuaternionOf<Real>& change);
  void gather(const rt::ImuSample& sample, Real dt_s);
  void level(const rt::Vector3& acc_body);
  void restart_mean();
  void turn_world(const MatrixOf<Real>& about);
  void begin_block() {
    block_ = {};
    block_.restless = moving_;
  }
  void close_block(rt::Nanoseconds now_ns);
  void forget_unknown(Real dt_s);
  void watch_rest(bool restless, const Vector& rate, const Vector& acc_body, Real dt_s);
  HeadingBlock heading_block() const;
  /// Blocks make whole hundredths of a second: float and double pass a bound between two of them together.
  bool rests() const { return rest_s_ >= real(0.999 * config_.rest_time_s); }
  void turn_heading(Real turn);
  bool believe_young(const Vector& away, const Vector& body_force, Real dt_s);
  Vector correct_inclination();
  void note_variance(const Vector& away, const SlowStep<Real>& step, Real dt_s);
  void learn_bias(const Vector& correction, const Vector& rate, Real dt_s);
  void publish(const rt::ImuSample& sample);
  static Real real(double value) { return static_cast<Real>(value); }

  AttitudeConfig config_;
  rt::StampGate gate_;
  QuaternionOf<Real> q_;                    // body to world
  QuaternionOf<Real> q_error_{0, 0, 0, 0};  // what rounding took from q_, put back at the next step
  MatrixOf<Real> turn_;                     // the same as a matrix
  Vector last_rate_;                        // raw gyro reading of the last used sample
  Real last_step_s_{};                      // interval that last_rate_ is the mean of
  Block block_;
  rt::Nanoseconds block_end_ns_{std::numeric_limits<rt::Nanoseconds>::min()};
  SlowVector<Real> force_;           // low-passed specific force, world
  SlowVector<Real> row_x_, row_y_;   // low-passed rows of the rotation matrix
  SlowValue<Real> seen_x_, seen_y_;  // low-passed bias in the world
  Real mean_s_{};                    // time since levelling
  Real doubted_s_{};                 // time left out of a young mean
  Real deviation_{};                 // mean size of the force's deviation, sum of absolute coordinates
  GyroBias<Real> bias_;
  HeadingHold<Real> hold_;
  TrackAid<Real> aid_;
  Vector mean_rate_;  // for the detection of rest
  Vector mean_acc_;
  Real rest_s_{};
  Real tilt_variance_{};     // of the inclination per axis, from accelerations
  Real unknown_turn_rad_{};  // that clipped samples may have hidden, of late
  double delta_heading_rad_{};
  rt::Nanoseconds usual_step_ns_{};
  std::uint32_t even_steps_{};  // how sure that is
  std::uint32_t zero_rates_{};  // all-zero readings refused in a row
  std::uint32_t refused_{};     // samples refused since the last used one
  rt::ImuSample held_sample_;   // after a wide step, until the next sample tells what it was
  Vector refused_rate_;         // of the one refused sample
  bool has_refused_rate_{};
  bool held_{};
  bool levelled_{};
  bool coasted_{};
  bool clipped_{};
  bool moving_{};
  bool told_{};  // whether it moves
  bool heading_invalid_{};
  AttitudeCounters counters_;
  rt::AttitudeEstimate estimate_;
};

/// A turned attitude is the old one plus a change, not a product: with its own rounding carried along, a day
/// in float ends where one in double does. The length stays one by a step of Newton's method.
template <class Real>
inline void BasicAttitude<Real>::add_change(const QuaternionOf<Real>& change) {
  const Real shrink = Real{0.5} * (Real{1} - (q_.w * q_.w + q_.x * q_.x + q_.y * q_.y + q_.z * q_.z));
  add_exactly(q_.w, q_error_.w, change.w + shrink * q_.w);
  add_exactly(q_.x, q_error_.x, change.x + shrink * q_.x);
  add_exactly(q_.y, q_error_.y, change.y + shrink * q_.y);
  add_exactly(q_.z, q_error_.z, change.z + shrink * q_.z);
}

/// A quiet sensor whose tracks stand stands at once; without tracks it has to be quiet for a while, as a slow
/// turn by hand is quiet, too.
template <class Real>
inline HeadingBlock BasicAttitude<Real>::heading_block() const {
  if (rests()) return HeadingBlock::rests;
  if (!(rest_s_ > Real{0})) return told_ && !moving_ ? HeadingBlock::quiet : HeadingBlock::moves;
  return told_ ? HeadingBlock::stands : HeadingBlock::quiet;
}

/// In double precision, as the runtime uses it.
using Attitude = BasicAttitude<double>;
/// In single precision, for boards without double: the same within 0.01 deg.
using AttitudeFloat = BasicAttitude<float>;

}  // namespace sortie::estimators
