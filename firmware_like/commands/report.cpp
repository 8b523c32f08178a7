// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "firmware_like/commands/commands.hpp"
#include "firmware_like/commands/replay_report.hpp"

namespace sortie::firmware {

void add_report(CLI::App& app, CommandContext& context) {
  struct Options {
    ReplayReportOptions replay;
    OutputOptions output;
  };
  auto options = std::make_shared<Options>();
  options->output.out = "report";
  CLI::App* command = app.add_subcommand("report", "Replay a log and write one page about it: report.html");
  command->footer(
      "Examples:\n"
      "  sortie report hall.lcm --out out/hall\n"
      "  sortie report husky.lcm --scene skid_outdoor --align se2 --out out/husky");
  add_replay_report_options(*command, options->replay);
  command->add_option("--out", options->output.out, "Folder")->type_name("DIR")->capture_default_str();
  command->callback([&context, options] {
    context.chosen = [&context, options] {
      return replay_and_show(context, options->replay, options->output);
    };
  });
}

}  // namespace sortie::firmware
