// SPDX-License-Identifier: BSD-3-Clause
// Run time over time, with bands where the odometry was on an obstacle.
#pragma once

#include "toolchain/judge/job_timeline.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// The longest job of each group in each span, on a log axis; bands for modes other than planar, and their
/// share of the time in the legend. Without jobs the plot has no series.
Plot plot_timeline(const JobTimeline& timeline);

}  // namespace sortie::toolchain
