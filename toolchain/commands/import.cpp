// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>
#include <memory>

#include "firmware_like/scene/json_reader.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/import/importer.hpp"

namespace sortie::toolchain {

void add_import(firmware::Command& app, CommandContext& context) {
  struct Options {
    ImportOptions import;
    bool json{};
  };
  auto options = std::make_shared<Options>();
  firmware::Command* command =
      app.add_subcommand("import", "Turn a recorded data set into an LCM log that replays");
  command->footer(
      "Examples:\n"
      "  sortie import husky data/husky_skid -o husky.lcm\n"
      "  sortie import rls data/os64.rls -o walk.lcm\n"
      "  sortie import rls data/os64.rls -o bare.lcm --no-poses\n"
      "  sortie import carmen data/aces.clf -o aces.lcm\n"
      "  sortie import broad data/trial.imu -o trial.lcm --strict");
  command->add_option("kind", options->import.kind, "What the data set is")
      ->required()
      ->one_of(import_kinds());
  command->add_option("path", options->import.path, "Folder of the data set, or one of its files")
      ->required();
  command->add_option("-o,--output", options->import.out, "LCM log to write")->required()->type_name("LOG");
  command->add_flag("--strict", options->import.strict, "One bad row is an error");
  command->add_flag("--no-poses", options->import.no_poses,
                    "rls: scans without their poses, which become truth alone");
  command
      ->add_option("--max-range", options->import.max_range_m,
                   "carmen: a reading from here on is no return, whatever the log says")
      ->type_name("M");
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback(context.choose([options] {
    const ImportReport report = import_log(options->import);
    for (const std::string& warning : report.warnings) std::cerr << "warning: " << warning << "\n";
    if (options->json) {
      firmware::Json object{{"log", options->import.out}};
      object.update(firmware::json_of(report));
      object.update({{"returns", firmware::json_of(report.returns)},
                     {"sources", report.sources},
                     {"warnings", report.warnings}});
      show_json(object);
    } else {
      std::cout << options->import.out << ": " << report.events << " events (" << report.imu << " imu, "
                << report.tracks << " track, " << report.scans << " scans, " << report.truth
                << " truth) from " << report.rows << " rows, " << report.bad_rows << " bad rows dropped\n";
      if (report.returns.in > 0)
        std::cout << "returns: " << report.returns.used << " of " << report.returns.in << " used, "
                  << report.returns.no_return + report.returns.out_of_range << " no return, "
                  << report.returns.not_finite << " not finite, "
                  << report.returns.time_negative + report.returns.time_unsorted + report.returns.time_beyond
                  << " with a time that cannot be\n";
    }
    return 0;
  }));
}

}  // namespace sortie::toolchain
