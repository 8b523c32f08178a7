// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/doctor/doctor_command.hpp"

#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "firmware_like/doctor/doctor.hpp"
#include "firmware_like/doctor/doctor_table.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {

namespace {

struct Options {
  DoctorOptions doctor;
  double seconds{1};
  bool json{};
};

int run(const Options& options) {
  const Doctor doctor(options.doctor);
  std::this_thread::sleep_for(std::chrono::duration<double>(options.seconds));
  const DoctorReport report = doctor.report();
  if (options.json) {
    std::cout << to_json(report).dump(2) << "\n";
  } else {
    print_doctor(std::cout, report, wants_colour(STDOUT_FILENO));
  }
  return report.verdict() == Health::bad ? 1 : 0;
}

}  // namespace

void add_doctor(Command& app, std::function<int()>& chosen) {
  auto options = std::make_shared<Options>();
  Command* command =
      app.add_subcommand("doctor", "Is this board set up for real time? Each finding with its cure");
  command->footer(
      "Changes nothing. Exit code 1 when something is bad.\n"
      "Examples:\n"
      "  sortie doctor\n"
      "  sortie doctor --core 3\n"
      "  sortie doctor --json");
  command->add_option("--core", options->doctor.core, "The core that is meant for the robot's tasks")
      ->not_negative()
      ->type_name("N");
  command->add_option("--seconds", options->seconds, "How long interrupts and stolen time are counted")
      ->in_range(0.0, 3600.0)
      ->capture_default_str();
  command
      ->add_option("--root", options->doctor.root,
                   "Look at files of another machine: its proc, sys and dev below DIR")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback([&chosen, options] { chosen = [options] { return run(*options); }; });
}

}  // namespace sortie::firmware
