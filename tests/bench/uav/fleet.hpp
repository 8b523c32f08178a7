// SPDX-License-Identifier: BSD-3-Clause
// Vehicles that nobody tuned for: drawn at random within what flies.
#pragma once

#include "tests/bench/uav/flight.hpp"

namespace sortie::bench {

/// A multirotor of 0.4 to 8 kg with 4, 6 or 8 rotors, lags of 6 to 45 ms and thrust of 1.4 to 3.5 times its
/// weight; the model is right but for what RotorS' models are wrong in (3 % of mass, 5 % of inertia).
FlightSetup random_vehicle(std::uint64_t seed, double least_lift = 1.4);

/// `path` is a hover in (0, 0, height) with zero yaw.
void hover_at(FlightSetup& setup, double height_m);

}  // namespace sortie::bench
