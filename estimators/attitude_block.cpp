// SPDX-License-Identifier: BSD-3-Clause
// What a block of samples costs: inclination, gyro bias, rest, variance.
#include <algorithm>
#include <cmath>

#include "estimators/attitude.hpp"

namespace sortie::estimators {
namespace {
constexpr double kWeightless_m_s2 = 1.0;
constexpr double kVarianceTime_s = 10.0;   // over which corrections are averaged to a variance
constexpr double kWalk_rad_s = 0.0017453;  // of the bias in bias_forgetting_s
constexpr double kYoung_s = 1.0;
constexpr double kNearer_m_s2 = 0.03;  // by so much one force has to be nearer to gravity than another
constexpr double kGravity_m_s2 = 9.81;
}  // namespace

template <class Real>
void BasicAttitude<Real>::restart_mean() {
  mean_s_ = Real{0};
  doubted_s_ = Real{0};
  begin_block();
  rest_s_ = Real{0};
  aid_.interrupt();
}

template <class Real>
void BasicAttitude<Real>::close_block(rt::Nanoseconds now_ns) {
  const Block block = block_;
  begin_block();
  const Real dt_s = block.time_s;
  const bool felt = block.force_s > Real{0};
  const Real share = felt ? Real{1} / block.force_s : Real{0};
  const Vector rate = (Real{1} / dt_s) * block.rate;
  const Vector body_force = share * block.body_force;
  watch_rest(block.restless || !felt, rate, body_force, dt_s);
  const HeadingBlock heading = heading_block();
  const Real noise = real(config_.gyr_noise_rad_s_rthz);
  if (heading == HeadingBlock::moves || heading == HeadingBlock::quiet) {
    bias_.integrate(turn_.z, dt_s + hold_.doubted_s(), noise * noise * dt_s);
  } else {
    bias_.add_heading(noise * noise * dt_s);  // who stands may be nudged: careful, not proud
  }
  const auto turn = hold_.close(config_, heading, block.heading, dt_s);
  bias_.add_heading(turn.variance);
  if (unknown_turn_rad_ > Real{0}) forget_unknown(dt_s);
  if (!felt) return turn_heading(turn.now);
  Vector force = force_.value() + share * block.away;
  if (!believe_young(share * block.away, body_force, dt_s)) return turn_heading(turn.now);
  // To a young mean each block counts much, and so does the noise of a speed.
  if (mean_s_ < real(kYoung_s)) aid_.interrupt();
  if (aid_.correct(config_, turn_, last_rate_ - bias_.value(), now_ns, dt_s, force_.z.value,
                   share * block.cut, force)) {
    ++counters_.aid_refused;
  }
  const SlowStep<Real> step(dt_s, mean_s_, real(config_.acc_time_constant_s));
  const Vector row_x = share * block.row_x;
  const Vector row_y = share * block.row_y;
  seen_x_.take(dot(row_x, bias_.value()), step);
  seen_y_.take(dot(row_y, bias_.value()), step);
  row_x_.take(row_x, step);
  row_y_.take(row_y, step);
  const Vector before = force_.value();
  force_.take(force, step);
  const Vector correction = correct_inclination();
  note_variance(force - before, step, dt_s);
  learn_bias(correction, rate, dt_s);
  turn_heading(turn.now);
  mean_s_ += dt_s;
}

/// The low-passed vectors stay: they lie along the vertical, or forget so small a turn sooner than it grows.
template <class Real>
void BasicAttitude<Real>::turn_heading(Real turn) {
  add_change(exp_minus_one(Vector{Real{0}, Real{0}, turn}) * q_);
  delta_heading_rad_ += static_cast<double>(turn);
  turn_ = matrix_of(q_);
}

/// Clipped and lost stretches: much unknown turn makes the filter average its inclination afresh.
template <class Real>
void BasicAttitude<Real>::forget_unknown(Real dt_s) {
  const Real unknown = unknown_turn_rad_;
  if (unknown > real(config_.relevel_rad)) {
    bias_.add_heading(unknown * unknown);
    unknown_turn_rad_ = Real{0};
    mean_s_ = Real{0};
    doubted_s_ = Real{0};
    tilt_variance_ += unknown * unknown;
    return;
  }
  const Real kept = std::max(Real{0}, Real{1} - dt_s / real(config_.acc_time_constant_s));
  bias_.add_heading(unknown * unknown * (Real{1} - kept));
  unknown_turn_rad_ = kept * unknown;
}

/// A young mean has no spread to judge a blow by, and a blow of 10 ms in the first second would lean it for
/// seconds. So a block that differs from the mean is weighed against it: the one whose size is nearer to
/// gravity is right. Either the mean begins anew, or the block is left out and the gyro carries over it; for
/// a second in all, as a robot may move from the first sample on.
template <class Real>
bool BasicAttitude<Real>::believe_young(const Vector& away, const Vector& body_force, Real dt_s) {
  const Real spread = real(0.5 * config_.rest_acc_m_s2);
  const bool young = mean_s_ > Real{0} && mean_s_ < real(kYoung_s) && doubted_s_ < real(kYoung_s);
  if (!young || dot(away, away) <= spread * spread) return true;
  const auto odd = [](const Vector& force) {
    return std::fabs(std::sqrt(dot(force, force)) - real(kGravity_m_s2));
  };
  const Real nearer = odd(force_.value()) - odd(body_force);
  const bool anew = nearer > real(kNearer_m_s2);
  const bool out = nearer < -real(kNearer_m_s2);
  if (anew || out) doubted_s_ += anew ? mean_s_ : dt_s;
  if (anew) mean_s_ = Real{0};
  return !out;
}

/// At rest the gyro reads its bias. A steady slow turn within max_bias_rad_s looks the same: the price of
/// having no other witness than the tracks.
template <class Real>
void BasicAttitude<Real>::watch_rest(bool restless, const Vector& rate, const Vector& acc_body, Real dt_s) {
  // In motion the means only wait for the stop, and belts that stand know when that was.
  const bool follow = moving_ || (told_ && restless);
  const Real weight = follow ? Real{1} : dt_s / (real(config_.rest_mean_s) + dt_s);
  mean_rate_ = mean_rate_ + weight * (rate - mean_rate_);
  mean_acc_ = mean_acc_ + weight * (acc_body - mean_acc_);
  const Real most = real(config_.max_bias_rad_s);
  const bool slow =
      std::fabs(mean_rate_.x) <= most && std::fabs(mean_rate_.y) <= most && std::fabs(mean_rate_.z) <= most;
  rest_s_ = slow && !restless && !coasted_ && !moving_ ? rest_s_ + dt_s : Real{0};
}

/// The shortest rotation that makes the low-passed force point up, in full, and the low-pass with it. Returns
/// it as a rotation vector (small angles).
template <class Real>
VectorOf<Real> BasicAttitude<Real>::correct_inclination() {
  const Vector force = force_.value();
  const Real size = std::sqrt(dot(force, force));
  if (size < real(kWeightless_m_s2)) return {};
  const Real inverse = Real{1} / size;
  const Real w = size + force.z;
  QuaternionOf<Real> less{Real{-1}, Real{1}, Real{0}, Real{0}};  // the turn minus one; upside down: any way
  if (w > real(1e-6) * size) {
    const Real scale = Real{1} / std::sqrt(Real{2} * size * w);
    less = {Real{0}, scale * force.y, -scale * force.x, Real{0}};
    less.w = -(less.x * less.x + less.y * less.y) / (Real{1} + scale * w);
  }
  add_change(less * q_);
  const QuaternionOf<Real> turn{Real{1} + less.w, less.x, less.y, less.z};
  force_.set({Real{0}, Real{0}, size}, rotate(turn, force_.slope()));
  return {inverse * force.y, -inverse * force.x, Real{0}};
}

/// The slope of the low-passed force, over its cut-off, has the variance of the low-passed force itself where
/// accelerations are white, and more where they average out: read off, not assumed. While averaging, the
/// variance of a mean.
template <class Real>
void BasicAttitude<Real>::note_variance(const Vector& away, const SlowStep<Real>& step, Real dt_s) {
  const Real size = force_.z.value;
  if (size < real(kWeightless_m_s2)) return;
  const Vector slope = force_.slope();
  const Real square = step.weight > Real{0} ? step.weight * (away.x * away.x + away.y * away.y)
                                            : slope.x * slope.x + slope.y * slope.y;
  const Real weight = dt_s / (std::min(real(kVarianceTime_s), mean_s_) + dt_s);
  tilt_variance_ += weight * (Real{0.5} * square / (size * size) - tilt_variance_);
}

/// The noise of an observation is such that the variance settles at the square of the wanted sigma: p with
/// p^2 / (p + noise) = growth. At rest the gyro is the observation; in motion the rate at which the
/// inclination had to be corrected, which follows the bias through the same low-pass as the attitude.
template <class Real>
void BasicAttitude<Real>::learn_bias(const Vector& correction, const Vector& rate, Real dt_s) {
  const Real initial = real(config_.bias_sigma_initial_rad_s);
  if (!(initial > Real{0})) return;
  const Real growth = real(kWalk_rad_s * kWalk_rad_s / config_.bias_forgetting_s) * dt_s;
  bias_.grow(growth, initial * initial);
  const bool rest = rests();
  const Real sigma = real(rest ? config_.bias_sigma_rest_rad_s : config_.bias_sigma_motion_rad_s);
  const Real variance = sigma * sigma;
  const Real noise = variance * variance / growth + variance;
  const Real most = real(config_.max_bias_rad_s);
  Real turn{};
  if (rest) {
    turn += bias_.observe({1, 0, 0}, rate.x, noise, most);
    turn += bias_.observe({0, 1, 0}, rate.y, noise, most);
    turn += bias_.observe({0, 0, 1}, rate.z, noise, most);
  } else if (mean_s_ >= real(config_.acc_time_constant_s)) {  // a young mean jumps about
    const Real per_s = Real{1} / dt_s;
    turn += bias_.observe(row_x_.value(), seen_x_.value - per_s * correction.x, noise, most);
    turn += bias_.observe(row_y_.value(), seen_y_.value - per_s * correction.y, noise, most);
  }
  if (!config_.heading_follows_bias) return;
  if (rest) {
    hold_.learn(turn, dot(turn_.z, rate), dt_s);
  } else {
    hold_.owe(turn);
  }
}

template <class Real>
void BasicAttitude<Real>::covariance(double (&out)[9]) const {
  const Real tau = real(config_.acc_time_constant_s);
  const double own = config_.acc_bias_m_s2 / kGravity_m_s2;
  const double floor = levelled_ ? own * own + static_cast<double>(tilt_variance_) : 1.0;
  const double xy = static_cast<double>(tau * tau * bias_.covariance_along(turn_.x, turn_.y));
  out[0] = floor + static_cast<double>(tau * tau * bias_.covariance_along(turn_.x, turn_.x));
  out[4] = floor + static_cast<double>(tau * tau * bias_.covariance_along(turn_.y, turn_.y));
  out[8] = static_cast<double>(bias_.heading_variance() + hold_.owed() * hold_.owed());
  out[1] = out[3] = xy;
  out[2] = out[5] = out[6] = out[7] = 0.0;
}

#define SORTIE_INSTANTIATE(Real)                                   \
  template void BasicAttitude<Real>::restart_mean();               \
  template void BasicAttitude<Real>::close_block(rt::Nanoseconds); \
  template void BasicAttitude<Real>::covariance(double(&)[9]) const;
SORTIE_INSTANTIATE(double)
SORTIE_INSTANTIATE(float)
#undef SORTIE_INSTANTIATE

}  // namespace sortie::estimators
