// SPDX-License-Identifier: BSD-3-Clause
// Key frames of a map, and how places hang on them: exact, in whole numbers.
#pragma once

#include <cmath>
#include <cstdint>

#include "mapping/recognition/place_cm.hpp"
#include "rt/describe.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {

/// A turn about the upright: cosine and sine of its angle in parts of 2^30. Whole numbers, so that a place
/// that is turned has the same bits on every board. Off by 1 cm at most 10,000 km away.
struct Heading {
  static constexpr std::int32_t kOne = 1 << 30;
  std::int32_t cosine{kOne};
  std::int32_t sine{};
  bool operator==(const Heading&) const = default;
  SORTIE_FIELDS(cosine, sine)

  /// Whether it is a turn: both as good as rounding leaves them.
  bool usable() const {
    if (cosine > kOne || cosine < -kOne || sine > kOne || sine < -kOne) return false;
    const std::int64_t off =
        std::int64_t{cosine} * cosine + std::int64_t{sine} * sine - std::int64_t{kOne} * kOne;
    return off < (std::int64_t{1} << 32) && off > -(std::int64_t{1} << 32);
  }
};

/// Heading of a direction (x, y) in the plane, of any length between 1e-100 and 1e100. False, and `heading`
/// as it was, for others and for what is not finite.
inline bool heading_of(double x, double y, Heading& heading) {
  const double square = x * x + y * y;
  if (!(square > 1e-200 && square < 1e200)) return false;
  const double length = std::sqrt(square);
  heading.cosine = static_cast<std::int32_t>(rt::floor(x / length * Heading::kOne + 0.5));
  heading.sine = static_cast<std::int32_t>(rt::floor(y / length * Heading::kOne + 0.5));
  return true;
}

/// A key frame in the map: level, so three numbers for its place and a turn are all of it.
struct KeyFramePose {
  /// 4,970 km: what hangs on it is not beyond ConsistencySweep::kMostPlaceCm, where no search goes on.
  static constexpr std::int32_t kFarthestCm = 497'000'000;
  PlaceCm place;
  Heading heading;
  bool operator==(const KeyFramePose&) const = default;
  SORTIE_FIELDS(place, heading)

  bool usable() const {
    const auto is_far = [](std::int32_t at) { return at > kFarthestCm || at < -kFarthestCm; };
    return !is_far(place.x) && !is_far(place.y) && !is_far(place.z) && heading.usable();
  }
};

/// How far a segment may be from its key frame along each axis, cm: 10 km. No sum of a place and an offset
/// overflows.
inline constexpr std::int32_t kFarthestOffsetCm = 1 << 20;

/// Whether an offset lies within kFarthestOffsetCm.
inline bool is_usable_offset(const PlaceCm& offset) {
  const auto is_far = [](std::int32_t at) { return at > kFarthestOffsetCm || at < -kFarthestOffsetCm; };
  return !is_far(offset.x) && !is_far(offset.y) && !is_far(offset.z);
}

namespace detail {
/// To the next whole number, halves upwards.
inline std::int32_t from_parts(std::int64_t parts) {
  return static_cast<std::int32_t>((parts + Heading::kOne / 2) >> 30);
}
}  // namespace detail

/// Place in the map of an offset from a key frame, both usable. Four products.
inline PlaceCm place_of(const KeyFramePose& frame, const PlaceCm& offset) {
  const std::int64_t c = frame.heading.cosine;
  const std::int64_t s = frame.heading.sine;
  return {frame.place.x + detail::from_parts(c * offset.x - s * offset.y),
          frame.place.y + detail::from_parts(s * offset.x + c * offset.y), frame.place.z + offset.z};
}

/// Offset of a place from a key frame, of two places within +-kFarthestCm of the map's origin: place_of() of
/// it is `place` to 1 cm along each axis.
inline PlaceCm offset_of(const KeyFramePose& frame, const PlaceCm& place) {
  const std::int64_t c = frame.heading.cosine;
  const std::int64_t s = frame.heading.sine;
  const std::int64_t x = std::int64_t{place.x} - frame.place.x;
  const std::int64_t y = std::int64_t{place.y} - frame.place.y;
  return {detail::from_parts(c * x + s * y), detail::from_parts(c * y - s * x), place.z - frame.place.z};
}

/// Square of how far two places in the map are apart, cm^2.
inline std::int64_t square_apart(const PlaceCm& a, const PlaceCm& b) {
  const std::int64_t x = std::int64_t{a.x} - b.x;
  const std::int64_t y = std::int64_t{a.y} - b.y;
  const std::int64_t z = std::int64_t{a.z} - b.z;
  return x * x + y * y + z * z;
}

}  // namespace sortie::mapping
