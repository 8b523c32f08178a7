// SPDX-License-Identifier: BSD-3-Clause
// The paper's metrics: distance in place (d_t) and attitude (d_w) between a drive and its reference, at the
// end and summed over 100 samples.
#pragma once

#include <memory>
#include <vector>

#include "tests/bench/plant/bench_vehicle.hpp"

namespace sortie::bench {

constexpr int kSamples = 100;

/// Poses at kSamples moments, evenly spaced, the last one at the end.
using Path = std::vector<BenchPose>;

/// The eight figures in half: one of place (m), one of attitude (rad), at the end and as sums.
struct Deviation {
  double end_d_t{};
  double end_d_w{};
  double sum_d_t{};
  double sum_d_w{};
};

/// Drives a scene and keeps the samples; the pose before t = 0 goes into `start`.
Path sample_drive(BenchVehicle& vehicle, const BenchScene& scene, double dt_s, BenchPose* start = nullptr);

/// Our plant's samples at 0.25 ms: the reference where there is no closed form. Driven once, then kept.
const Path& fine_path(const BenchScene& scene);

/// The difference to a scene's reference. Closed forms begin at the scene's start; where it is left to
/// settle, at `settled`.
Deviation deviation(const Path& path, const BenchScene& scene, const BenchPose& settled);

/// Drives a vehicle and compares.
Deviation deviation_of(BenchVehicle& vehicle, const BenchScene& scene, double dt_s);

}  // namespace sortie::bench
