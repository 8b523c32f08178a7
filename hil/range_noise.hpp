// SPDX-License-Identifier: BSD-3-Clause
// What every range sensor does wrong, in one model: noise, bias, steps, lost and mixed returns.
#pragma once

#include <cstdint>

#include "hil/random.hpp"
#include "hil/ray_caster.hpp"

namespace sortie::hil {

/// Errors of a range sensor. A zero switches an error off.
struct RangeNoiseConfig {
  double sigma_m{0.015};     ///< standard deviation of a range, 0..1
  double sigma_share{0.0};   ///< of the true range, added to sigma_m, 0..0.1
  double bias_m{0.0};        ///< added to every range, -1..1
  double resolution_m{0.0};  ///< ranges are multiples of this, 0..1
  double loss{0.005};        ///< share of returns that are lost, whatever they met, 0..1
  double graze_cos{0.0};     ///< below this |cos| of the incidence a return is lost with 1 - cos / graze_cos
  double full_range_m{0.0};  ///< beyond it a return is lost with 1 - (full_range / range)^2
  double divergence_rad{0.0};          ///< half angle of the beam: at edges near and far are mixed, 0..0.05
  rt::Nanoseconds stamp_jitter_ns{0};  ///< standard deviation of a scan's stamp, 0..1 ms, cut at 4 of them
};

/// What became of a ray.
enum class RayFate : std::uint8_t {
  returned,
  nothing,   ///< met nothing in range
  lost,      ///< by the share that is lost anyway
  weak,      ///< too flat or too far
  too_near,  ///< the measured range is below the least ...
  too_far,   ///< ... or above the largest that is reported
};

/// Truth of one ray: of its axis, without any error.
struct RangeTruth {
  double range_m{};                   ///< max_range where it met nothing
  double cos_incidence{};             ///< |cos|
  std::int32_t solid{Hit::kNothing};  ///< as in RangeHit
  bool mixed{};                       ///< the measured range is a mixture of this and something beside it
};

/// A measured range, and what is true about it.
struct RangeReading {
  double range_m{};  ///< only of a ray that returned
  RayFate fate{RayFate::nothing};
  std::uint16_t reflectivity{};
  RangeTruth truth;
};

/// Counts of a sensor's rays.
struct RangeCounters {
  std::uint64_t rays{};
  std::uint64_t returned{};
  std::uint64_t nothing{};
  std::uint64_t lost{};
  std::uint64_t weak{};
  std::uint64_t too_near{};
  std::uint64_t too_far{};
  std::uint64_t mixed{};    ///< of those that returned
  std::uint64_t own{};      ///< of those that returned: from the robot itself
  std::uint64_t refused{};  ///< rays whose pose was no pose: nothing was cast
};

/// The model. The draws of a ray do not depend on what it meets. No heap. 0.2 kB.
class RangeNoise {
 public:
  /// Throws std::runtime_error, "hil <who>: ..." with the setting, if the config is not usable; the sensor's
  /// least and largest range are checked with it.
  RangeNoise(const RangeNoiseConfig& config, double min_range_m, double max_range_m, const char* who);

  /// Begins a scan or frame: what follows depends on these two numbers only.
  void begin(std::uint64_t seed, std::uint64_t stream);

  /// Error of this scan's stamp. One draw, where there is any jitter.
  rt::Nanoseconds stamp_error_ns();

  /// Fires one ray and measures it. `direction_sensor` has length 1. Cost: a cast, with divergence two; 50 ns
  /// of draws. `met`, if there is one, receives what the beam's axis met.
  RangeReading fire(const RayCaster& caster, const RayCaster::Aim& aim, const Vec3& direction_sensor,
                    RangeHit* met = nullptr);
  /// The ray of a sensor that nobody knows the place of: draws like any ray, and returns nothing.
  RangeReading fire_nowhere();

  const RangeCounters& counters() const { return counters_; }

 private:
  struct Draws {
    bool lost{};
    double error{};   ///< standard normal
    double weak{};    ///< uniform
    double around{};  ///< uniform: where beside the axis the beam's edge is looked at
    double share{};   ///< uniform: of what was met there
  };
  Draws draw();
  RangeReading measure(const RangeHit& hit, const Draws& draws, double met_m, bool mixed);
  double chance_of_return(const RangeHit& hit) const;

  RangeNoiseConfig config_;
  double min_range_m_;
  double max_range_m_;
  Random random_;
  Random extra_;  ///< of what the plainest sensor does not have: it does not move the plain draws
  RangeCounters counters_{};
};

}  // namespace sortie::hil
