// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware_like/commands/commands.hpp"
#include "firmware_like/commands/replay_report.hpp"
#include "firmware_like/exporters/output_file.hpp"
#include "firmware_like/json_reader.hpp"

namespace sortie::firmware {

namespace {

struct PageOptions {
  std::vector<std::string> logs;
  ReplayReportOptions replay;
  OutputOptions output;
};

// Several logs on one page; their results in one file, in the order of the logs.
int report_all(const CommandContext& context, PageOptions& options) {
  std::vector<ReportInput> reports;
  Plot ground;
  Json results = Json::array();
  std::string damage;
  for (const std::string& log : options.logs) {
    ReplayedLog replayed = replay_for_report(context, options.replay, options.output, log);
    if (ground.series.empty()) ground = std::move(replayed.ground);
    results.push_back(to_json(replayed.report.results));
    print_table(std::cout, replayed.report.results, wants_colour(STDOUT_FILENO));
    if (damage.empty()) damage = replayed.damage;
    reports.push_back(std::move(replayed.report));
  }
  std::filesystem::create_directories(options.output.out);
  write_file(options.output.out + "/results.json", [&results](std::ostream& out) {
    out << Json{{"runs", results}}.dump(2) << "\n";
  });
  const std::string page = options.output.out + "/report.html";
  write_report(page, render_report(reports, ground));
  std::cerr << "report: " << page << "\n";
  return finish_with_damage(context, damage, options.replay.accept_damage, 0);
}

}  // namespace

void add_report(CLI::App& app, CommandContext& context) {
  auto options = std::make_shared<PageOptions>();
  options->output.out = "report";
  CLI::App* command = app.add_subcommand("report", "Replay logs and write one page about them: report.html");
  command->footer(
      "Examples:\n"
      "  sortie report hall.lcm --out out/hall\n"
      "  sortie report husky.lcm --scene skid_outdoor --align se2 --out out/husky\n"
      "  sortie report ugv.lcm uav.lcm --out out/mission");
  command->add_option("logs", options->logs, "LCM logs from `run --record` or `import`")
      ->required()
      ->type_name("LOG");
  add_replay_report_options(*command, options->replay);
  command->add_option("--out", options->output.out, "Folder")->type_name("DIR")->capture_default_str();
  command->callback([&context, options] {
    context.chosen = [&context, options] {
      if (options->logs.size() > 1) return report_all(context, *options);
      options->replay.log = options->logs.front();
      return replay_and_show(context, options->replay, options->output);
    };
  });
}

}  // namespace sortie::firmware
