// SPDX-License-Identifier: BSD-3-Clause
// Errors of simulated track encoders: whole counts, a wrong sprocket radius and an arbitrary start.
#pragma once

#include <cmath>
#include <cstdint>

#include "hil/motion.hpp"
#include "rt/samples.hpp"

namespace sortie::hil {

/// The encoders of both tracks.
struct EncoderConfig {
  std::uint32_t rate_hz{100};   ///< must divide 1000
  double resolution_m{0.0005};  ///< travel of the belt per count
  double scale_left{1.0};       ///< shown travel / true travel of the belt (a worn sprocket)
  double scale_right{1.0};
  double start_left_m{0.0};  ///< what the encoders show at the start
  double start_right_m{0.0};
};

/// What the encoders show for a state: travel rounded down to whole counts. Cost: a few operations.
inline rt::TrackSample read_encoders(const EncoderConfig& config, const Motion& motion) {
  rt::TrackSample sample;
  sample.stamp_ns = motion.stamp_ns;
  const double left = config.start_left_m + config.scale_left * motion.left_m;
  const double right = config.start_right_m + config.scale_right * motion.right_m;
  sample.left_m = std::floor(left / config.resolution_m) * config.resolution_m;
  sample.right_m = std::floor(right / config.resolution_m) * config.resolution_m;
  return sample;
}

}  // namespace sortie::hil
