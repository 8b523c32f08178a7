// SPDX-License-Identifier: BSD-3-Clause
// What a page about several runs begins with.
#pragma once

#include <string>
#include <vector>

#include "toolchain/report/html.hpp"

namespace sortie::toolchain {

/// A table with a row a run, each with a link to `run1`, `run2`, ... on the same page.
std::string overview(const std::vector<ReportInput>& inputs);

/// The ways of all runs from above, over the dots of `ground`; it may be empty.
Plot plot_ways(const std::vector<ReportInput>& inputs, const Plot& ground);

}  // namespace sortie::toolchain
