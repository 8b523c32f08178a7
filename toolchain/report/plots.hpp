// SPDX-License-Identifier: BSD-3-Clause
// The standard plots of a run, made from its result and its trajectories.
#pragma once

#include <span>
#include <vector>

#include "firmware_like/log/contact_truth.hpp"
#include "firmware_like/result/results.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/judge/job_timeline.hpp"
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

/// Run time over time: the longest job of each group in each span, on a log axis; bands where the odometry
/// was in another mode than planar, and their share of the time in the legend. Without jobs the plot has no
/// series.
Plot plot_timeline(const JobTimeline& timeline);

/// What a simulated vehicle touched and how its flippers stood, over time: contacts by part, flipper angles
/// asked for and actual, flipper torques. Empty without summaries.
std::vector<Plot> plot_contacts(std::span<const firmware::ContactSummary> contacts);

}  // namespace sortie::toolchain
