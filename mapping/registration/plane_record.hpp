// SPDX-License-Identifier: BSD-3-Clause
// A plane in 28 bytes, for radio and storage.
//
// | bytes | what | step |
// |---|---|---|
// | 0-3 | normal, folded onto an octahedron, 2 x int16 | 0.003 deg |
// | 4-12 | centroid, 3 x int24 | 1 mm, within 8,388 m |
// | 13-14 | turn of axis u about the normal, half a turn in 65,536 | 0.0027 deg |
// | 15-18 | length and width of the rectangle, 2 x uint16 | 1 cm, at most 655.35 m |
// | 19-20 | where the centroid lies in it, 2 x uint8 | 1/255 of the side |
// | 21 | area over the rectangle's | 1/255 |
// | 22-24 | the three standard deviations, on a scale of 10 % steps | 5 % |
// | 25-27 | id, its lower 24 bits | exact |
#pragma once

#include <array>
#include <cstdint>

#include "mapping/registration/plane.hpp"

namespace sortie::mapping {

/// Bytes of a plane's record, little endian.
inline constexpr std::size_t kPlaneRecordBytes = 28;
using PlaneRecord = std::array<std::uint8_t, kPlaneRecordBytes>;

/// Bounds of what a record loses, for planes within its range (tested).
inline constexpr double kRecordNormal_rad = 6.5e-5;
inline constexpr double kRecordCentroid_m = 0.0005;  ///< along each axis
inline constexpr double kRecordAxis_rad = 9e-5;      ///< of u, with what the normal loses
inline constexpr double kRecordSide_m = 0.005;       ///< of length and width
inline constexpr double kRecordSigma = 0.05;         ///< relative

/// `not_finite` or `out_of_range` as check() says, and `out_of_range` for a centroid beyond 8,388 m or a side
/// beyond 655.35 m; then `record` is not touched. Standard deviations outside 1e-5 .. 3e5 and ids beyond 24
/// bits are cut to what fits. The side that a plane was seen from is kept: the normal keeps its sign.
Status encode(const Plane& plane, PlaneRecord& record);

/// `malformed` for bytes that encode() does not write (a normal off the octahedron); then `plane` is not
/// touched. What it gives passes check(). Any other bytes are some plane: a record has no checksum of its
/// own.
Status decode(const PlaneRecord& record, Plane& plane);

}  // namespace sortie::mapping
