// SPDX-License-Identifier: BSD-3-Clause
// The standard plots of a run, made from its result and its trajectories.
#pragma once

#include <span>

#include "firmware_like/evaluation/evaluate.hpp"
#include "firmware_like/report/svg.hpp"
#include "firmware_like/results.hpp"

namespace sortie::firmware {

/// Execution times of one task: log time, log count, with lines at budget and period (the deadline).
Plot plot_latency(const TaskResult& task);

/// Paths seen from above, truth under the estimate; equal aspect; start and end marked.
Plot plot_top(std::span<const TimedPose> estimate, std::span<const TimedPose> truth);

/// Paths seen along the world's y axis, truth only where it has a height. To scale unless the ground is so
/// flat that nothing would be seen; then the axis says so.
Plot plot_side(std::span<const TimedPose> estimate, std::span<const TimedPose> truth);

/// Position error over time.
Plot plot_position_error(std::span<const ErrorSample> errors);

/// Inclination and heading error over time.
Plot plot_orientation_error(std::span<const ErrorSample> errors);

}  // namespace sortie::firmware
