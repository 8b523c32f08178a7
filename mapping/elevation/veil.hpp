// SPDX-License-Identifier: BSD-3-Clause
// Returns that hang in the air between an edge and what lies behind it.
#pragma once

#include <span>

#include "rt/samples.hpp"

namespace sortie::mapping {

/// Copies the returns of a scan without veils into `kept`, as far as they fit; the number of those copied. A
/// beam that meets an edge gives one range for two things. Such a return lies between its two neighbours of
/// the scan in range, and the ways to both run along the beam: flatter than `most_slope` (tangent of the
/// angle between beam and way). Neighbours that are farther apart than 1.5 degrees are none. What is left of
/// a veil lies close to its edge. A floor counts as one where it is met flatter than that, 10 m away at 3
/// degrees and a sensor 0.5 m up. Points are in the sensor's frame. Cost: about 20 ns a return.
std::size_t without_veils(std::span<const rt::ScanPoint> points, double most_slope,
                          std::span<rt::ScanPoint> kept);

}  // namespace sortie::mapping
