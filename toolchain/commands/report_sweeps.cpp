// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/report_sweeps.hpp"

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/scene/profile.hpp"
#include "toolchain/judge/alignment.hpp"

#include <exception>

namespace sortie::toolchain {

std::vector<std::vector<Sweep>> sweep_for_report(const CommandContext& context,
                                                 const std::vector<std::string>& logs,
                                                 const SweepsOnPage& what, const ReplayReportOptions& options,
                                                 const OutputOptions& output) {
  std::vector<std::vector<Sweep>> sweeps(logs.size());
  SweepOptions sweep;
  sweep.replay = options.replay;
  sweep.replay.on_job = nullptr;
  if (!what.to.empty()) sweep.replay.to = what.to;
  sweep.evaluation = options.evaluation;
  sweep.evaluation.align = parse_alignment(options.align);
  for (const std::string& text : what.knobs) {
    sweep.knobs = parse_knobs({text});
    std::exception_ptr refusal;
    bool swept = false;
    for (std::size_t i = 0; i < logs.size(); ++i) {
      sweep.progress = progress_bar(output, "sweep");
      try {
        sweeps[i].push_back(run_sweep(firmware::LogFile(logs[i]), context.parts.vehicles, sweep));
        swept = true;
      } catch (const firmware::ProfileError&) {
        // Another robot's key; an error only where no log's scene takes it.
        refusal = std::current_exception();
      }
    }
    if (!swept && refusal) std::rethrow_exception(refusal);
  }
  return sweeps;
}

}  // namespace sortie::toolchain
