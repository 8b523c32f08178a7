// SPDX-License-Identifier: BSD-3-Clause
// The standard plots of a run, made from its result and its trajectories.
#pragma once

#include <span>

#include "firmware_like/result/results.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// Execution times of one task: log time, log count, with lines at budget and period (the deadline).
Plot plot_latency(const firmware::TaskResult& task);

/// Paths of one run.
struct RunPaths {
  std::span<const firmware::TimedPose> estimate;
  std::span<const firmware::TimedPose> truth;
  std::span<const firmware::TimedPose> located;  ///< on the map that the robot made
};

/// Paths seen from above, truth under the others; equal aspect; start and end marked.
Plot plot_top(const RunPaths& paths);

/// Paths seen along the world's y axis, truth only where it has a height. To scale unless the ground is so
/// flat that nothing would be seen; then the axis says so.
Plot plot_side(const RunPaths& paths);

/// Position error over time.
Plot plot_position_error(std::span<const ErrorSample> errors);

/// Inclination and heading error over time.
Plot plot_orientation_error(std::span<const ErrorSample> errors);

}  // namespace sortie::toolchain
