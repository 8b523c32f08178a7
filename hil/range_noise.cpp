// SPDX-License-Identifier: BSD-3-Clause
#include "hil/range_noise.hpp"

#include <algorithm>
#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr std::uint64_t kExtraStream = 0x6578747261000000;
// Parts of a beam whose ranges differ less lie on one surface; their mean is the axis' range.
constexpr double kEdge_m = 0.05;

bool within(double value, double low, double high) { return value >= low && value <= high; }

// A direction `angle_rad` beside `axis`, on the side that `around` (0..1) of a turn points to.
Vec3 beside(const Vec3& axis, double angle_rad, double around) {
  const Vec3 least = std::fabs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 a = cross(axis, least);
  const Vec3 u = (1.0 / norm(a)) * a;
  const Vec3 v = cross(axis, u);
  const rt::SinCos turn = rt::sincos(kTwoPi * around);
  const rt::SinCos off = rt::sincos(angle_rad);
  const Vec3 side = turn.cos * u + turn.sin * v;
  const Vec3 sum = off.cos * axis + off.sin * side;
  return (1.0 / norm(sum)) * sum;
}

}  // namespace

RangeNoise::RangeNoise(const RangeNoiseConfig& c, double min_range_m, double max_range_m, const char* who)
    : config_(c), min_range_m_(min_range_m), max_range_m_(max_range_m) {
  require(who, min_range_m >= 0.0 && max_range_m > min_range_m && max_range_m <= 1000.0,
          "0 <= min_range_m < max_range_m <= 1000 must hold");
  require(who, within(c.sigma_m, 0.0, 1.0), "sigma_m must lie in 0..1");
  require(who, within(c.sigma_share, 0.0, 0.1), "sigma_share must lie in 0..0.1");
  require(who, within(c.bias_m, -1.0, 1.0), "bias_m must lie in -1..1");
  require(who, within(c.resolution_m, 0.0, 1.0), "resolution_m must lie in 0..1");
  require(who, within(c.loss, 0.0, 1.0), "loss must lie in 0..1");
  require(who, within(c.graze_cos, 0.0, 1.0), "graze_cos must lie in 0..1");
  require(who, within(c.full_range_m, 0.0, 1000.0), "full_range_m must lie in 0..1000");
  require(who, within(c.divergence_rad, 0.0, 0.05), "divergence_rad must lie in 0..0.05");
  require(who, c.stamp_jitter_ns >= 0 && c.stamp_jitter_ns <= rt::kNanosecondsPerMillisecond,
          "stamp_jitter_ns must lie in 0..1000000");
}

void RangeNoise::begin(std::uint64_t seed, std::uint64_t stream) {
  random_ = Random(seed, stream);
  extra_ = Random(seed, stream ^ kExtraStream);
}

rt::Nanoseconds RangeNoise::stamp_error_ns() {
  if (config_.stamp_jitter_ns == 0) return 0;
  const double normal = std::clamp(extra_.normal(), -4.0, 4.0);
  return static_cast<rt::Nanoseconds>(normal * static_cast<double>(config_.stamp_jitter_ns));
}

RangeNoise::Draws RangeNoise::draw() {
  Draws draws;
  draws.lost = random_.chance(config_.loss);
  draws.error = random_.normal();
  if (config_.graze_cos > 0.0 || config_.full_range_m > 0.0) draws.weak = extra_.uniform();
  if (config_.divergence_rad > 0.0) {
    draws.around = extra_.uniform();
    draws.share = extra_.uniform();
  }
  return draws;
}

double RangeNoise::chance_of_return(const RangeHit& hit) const {
  double chance = 1.0;
  if (hit.cos_incidence < config_.graze_cos) chance = hit.cos_incidence / config_.graze_cos;
  if (config_.full_range_m > 0.0 && hit.range_m > config_.full_range_m) {
    const double share = config_.full_range_m / hit.range_m;
    chance *= share * share;
  }
  return chance;
}

RangeReading RangeNoise::fire(const RayCaster& caster, const RayCaster::Aim& aim,
                              const Vec3& direction_sensor, RangeHit* met) {
  const Draws draws = draw();
  const RangeHit hit = caster.cast(aim, direction_sensor, max_range_m_);
  if (met != nullptr) *met = hit;
  if (!hit || !(config_.divergence_rad > 0.0)) return measure(hit, draws, hit.range_m, false);
  const RangeHit edge =
      caster.cast(aim, beside(direction_sensor, config_.divergence_rad, draws.around), max_range_m_);
  if (!edge || !(std::fabs(edge.range_m - hit.range_m) > kEdge_m))
    return measure(hit, draws, hit.range_m, false);
  return measure(hit, draws, hit.range_m + draws.share * (edge.range_m - hit.range_m), true);
}

RangeReading RangeNoise::fire_nowhere() {
  static_cast<void>(draw());
  ++counters_.rays;
  ++counters_.refused;
  return {};
}

RangeReading RangeNoise::measure(const RangeHit& hit, const Draws& draws, double met_m, bool mixed) {
  RangeReading reading;
  reading.reflectivity = hit.reflectivity;
  reading.truth = {hit.range_m, hit.cos_incidence, hit.solid, mixed};
  const auto ended = [&reading](RayFate fate, std::uint64_t& counter) {
    ++counter;
    reading.fate = fate;
    return reading;
  };
  ++counters_.rays;
  if (!hit) return ended(RayFate::nothing, counters_.nothing);
  if (draws.lost) return ended(RayFate::lost, counters_.lost);
  if (draws.weak > 0.0 && draws.weak >= chance_of_return(hit)) return ended(RayFate::weak, counters_.weak);
  const double sigma_m = config_.sigma_m + config_.sigma_share * hit.range_m;
  double range_m = met_m + sigma_m * draws.error + config_.bias_m;
  if (config_.resolution_m > 0.0)
    range_m = config_.resolution_m * std::floor(range_m / config_.resolution_m + 0.5);
  if (range_m < min_range_m_) return ended(RayFate::too_near, counters_.too_near);
  if (range_m > max_range_m_) return ended(RayFate::too_far, counters_.too_far);
  if (mixed) ++counters_.mixed;
  if (hit.own()) ++counters_.own;
  reading.range_m = range_m;
  return ended(RayFate::returned, counters_.returned);
}

}  // namespace sortie::hil
