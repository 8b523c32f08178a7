// SPDX-License-Identifier: BSD-3-Clause
// A heading that stands while the robot stands, and what it is owed meanwhile.
#pragma once

#include <algorithm>

#include "estimators/attitude_config.hpp"

namespace sortie::estimators {

/// What a block of samples was, as far as the heading is concerned.
enum class HeadingBlock : unsigned char {
  moves,   ///< the robot moves
  quiet,   ///< it may stand: either the tracks say so or the sensor, not both
  stands,  ///< tracks and sensor stand, but not yet for long enough to be believed
  rests,   ///< it stands
};

/// The rule: **nothing turns the heading of a robot that stands**, neither the gyro's noise nor what rest
/// teaches about its bias. The first looks at a bias are noisy, and over minutes of motion that noise is
/// degrees of heading. So what is learned is gathered here, where later looks take back what earlier ones
/// claimed; the sum counts once, at the end of the rest, by what it is worth; and it is paid while the robot
/// moves, at a rate that no map and no drive notices. Whoever corrects the heading of the attitude filter by
/// something learned adds it here and never turns the attitude itself.
///
/// Worth: how far the bias can have drifted since it was known, against the white noise of the looks of this
/// rest, which is read off them. A rest of a second after a short drive tells mostly noise, a long one nearly
/// all.
///
/// What the gyro turned while the robot stood is dropped; if the robot did not stand after all, it is owed.
/// rad and s. Eight numbers; a few operations a block.
template <class Real>
class HeadingHold {
 public:
  /// Variance of the bias at the start.
  explicit HeadingHold(Real bias_variance) : drift_(bias_variance) {}

  /// What a block asks for.
  struct Turn {
    Real now{};       ///< the heading is to be turned by this
    Real variance{};  ///< by what a lesson was not worth the heading is less sure
  };

  /// By how much the heading should turn and does not yet: part of its error.
  Real owed() const { return owed_ + lesson_; }
  /// Time of the blocks that stood and are not yet believed.
  Real doubted_s() const { return doubted_s_; }

  /// A look at the bias in motion asks for `turn`.
  void owe(Real turn) { owed_ += turn; }
  /// A look of `dt_s` at rest does; it saw the vertical rate `seen`.
  void learn(Real turn, Real seen, Real dt_s) {
    lesson_ += turn;
    if (looked_s_ > Real{0}) rough_ += Real{0.5} * dt_s * dt_s * (seen - seen_) * (seen - seen_);
    seen_ = seen;
    looked_s_ += dt_s;
  }
  /// The heading is known anew: nothing is owed.
  void clear() { owed_ = lesson_ = withheld_ = doubted_s_ = Real{0}; }

  /// A block of `dt_s` in which the gyro turned the heading by `turned`.
  Turn close(const AttitudeConfig& config, HeadingBlock block, Real turned, Real dt_s) {
    if (block == HeadingBlock::stands) {
      withheld_ += turned;
      doubted_s_ += dt_s;
      return {-turned, Real{0}};
    }
    if (block == HeadingBlock::rests) {
      withheld_ = doubted_s_ = Real{0};
      return {-turned, Real{0}};
    }
    Turn turn{Real{0}, end_lesson(config)};
    owed_ += withheld_;
    withheld_ = doubted_s_ = Real{0};
    const auto walk = static_cast<Real>(config.bias_walk_rad_s_rts);
    drift_ += walk * walk * dt_s;
    if (block == HeadingBlock::quiet) return turn;
    const Real most = static_cast<Real>(config.heading_payment_rad_s) * dt_s;
    turn.now = std::clamp(owed_, -most, most);
    owed_ -= turn.now;
    return turn;
  }

  SORTIE_FIELDS(owed_, withheld_, doubted_s_, lesson_, looked_s_, seen_, rough_, drift_)

 private:
  Real end_lesson(const AttitudeConfig& config) {
    if (!(looked_s_ > Real{0})) return Real{0};
    const auto density = static_cast<Real>(config.gyr_noise_rad_s_rthz);
    // Of a look of one second: as the looks of this rest scattered, if that is more than is said.
    const Real noise = std::max(density * density, rough_ / looked_s_);
    const Real worth = looked_s_ * drift_ / (looked_s_ * drift_ + noise);
    const Real forgone = (Real{1} - worth) * lesson_;
    owed_ += worth * lesson_;
    constexpr Real kRemembered_s{18};  // the bias filter at rest averages over so long
    drift_ = std::max((Real{1} - worth) * drift_, noise / kRemembered_s);
    lesson_ = looked_s_ = rough_ = Real{0};
    return forgone * forgone;
  }

  Real owed_{};
  Real withheld_{};   // turned by the gyro while the robot stood, until that is believed
  Real doubted_s_{};  // for so long
  Real lesson_{};     // what this rest has taught so far
  Real looked_s_{};   // in this time
  Real seen_{};       // by the look before
  Real rough_{};      // half the square of the difference of two looks, times the square of their time
  Real drift_{};      // variance of the bias since it was known, (rad/s)^2
};

}  // namespace sortie::estimators
