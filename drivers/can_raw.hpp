// SPDX-License-Identifier: BSD-3-Clause
// Values to the raw numbers of CAN fields. Internal to the codecs.
#pragma once

#include <cmath>

#include "drivers/can_frames.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// Nearest whole number of steps of `scale`; the caller has checked that the result fits 64 bits.
inline std::int64_t to_raw(double value, double scale) {
  return static_cast<std::int64_t>(std::floor(value / scale + 0.5));
}

/// The same within an axis' 16 bits: what lies beyond becomes their end, as a saturated sensor would say.
inline std::int64_t to_axis(double value, double scale) {
  const auto limit = static_cast<double>(kCanAxisLimit);
  const double raw = value / scale;
  if (raw >= limit) return kCanAxisLimit;
  if (raw <= -limit) return -kCanAxisLimit;
  return to_raw(value, scale);
}

/// A frame of a known kind, all zero.
inline CanFrame blank(std::uint32_t id, rt::Nanoseconds stamp_ns) {
  CanFrame frame;
  frame.id = id;
  frame.stamp_ns = stamp_ns;
  frame.size = find_can_frame(id)->size;
  return frame;
}

}  // namespace sortie::drivers
