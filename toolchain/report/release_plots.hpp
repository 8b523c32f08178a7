// SPDX-License-Identifier: BSD-3-Clause
// How late the groups of a live run were: the plot that the OSADL made common, and the answer against the
// deadline.
#pragma once

#include <span>
#include <string>

#include "firmware_like/result/results.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// True when there is something to draw: releases were measured.
bool has_releases(std::span<const firmware::GroupResult> groups);

/// Wake-up latency: logarithmic count over microseconds, bins of 1 us, one line a group, its maximum marked.
/// The axis ends at the maximum or a little beyond the shortest deadline; a maximum that is farther out is an
/// arrow at the edge with its value in the legend.
Plot plot_wake_up(std::span<const firmware::GroupResult> groups);

/// From release to end of the job, both axes logarithmic, with a line at each group's deadline.
Plot plot_response(std::span<const firmware::GroupResult> groups);

/// Both plots in one SVG file, with a title.
std::string render_latency_file(std::span<const firmware::GroupResult> groups, const std::string& title);

}  // namespace sortie::toolchain
