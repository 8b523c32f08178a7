// SPDX-License-Identifier: BSD-3-Clause
// The few returns of a scan that a place is searched with.
#pragma once

#include <span>

#include "mapping/registration/scan_sample.hpp"

namespace sortie::mapping {

/// Chooses returns of a sample, at most out.size(), spread over all directions: in each of 31 sectors about
/// the upright first those next to the horizon, above and below, then the lowest and the highest, then the
/// others. Returns nearer than 0.6 m or farther than `reach_m` are left out. Out: turned by `q_level_sensor`,
/// m. How many. What it chooses depends on the sample's order, which is by chance and the same for the same
/// returns. No heap.
std::size_t choose_place_returns(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor,
                                 double reach_m, std::span<rt::Vector3> out);

}  // namespace sortie::mapping
