// SPDX-License-Identifier: BSD-3-Clause
// Error over run time for a page: knobs swept over the logs that it is about.
#pragma once

#include <string>
#include <vector>

#include "toolchain/commands/replay_report.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

/// What to sweep.
struct SweepsOnPage {
  std::vector<std::string> knobs;  ///< "key=v1,v2,v3" each
  std::string to;                  ///< time or @tick; empty: as far as the page's replay
};

/// Sweeps each knob by itself over every log whose scene knows the key; the result has
/// an entry a log. Throws ProfileError where no log's scene can be swept so, InputError.
std::vector<std::vector<Sweep>> sweep_for_report(const CommandContext& context,
                                                 const std::vector<std::string>& logs,
                                                 const SweepsOnPage& what, const ReplayReportOptions& options,
                                                 const OutputOptions& output);

}  // namespace sortie::toolchain
