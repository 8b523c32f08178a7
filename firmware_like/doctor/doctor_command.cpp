// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/doctor/doctor_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "firmware_like/doctor/doctor.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {

namespace {

constexpr std::size_t kIndent = 26;
constexpr std::size_t kWidth = 100;

// By Health: good, warn, bad, unknown.
constexpr const char* kColours[] = {"\033[32m", "\033[33m", "\033[31m", "\033[2m"};
constexpr int kRanks[] = {3, 1, 0, 2};

const char* colour_of(Health health) { return kColours[static_cast<std::size_t>(health)]; }
int rank(Health health) { return kRanks[static_cast<std::size_t>(health)]; }

/// Words from column kIndent on, broken before column kWidth; the first line has begun.
void print_wrapped(std::ostream& out, const std::string& text) {
  std::size_t column = kIndent;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (column > kIndent && column + 1 + end - begin > kWidth) {
      out << '\n' << std::string(kIndent, ' ');
      column = kIndent;
    } else if (column > kIndent) {
      out << ' ';
      ++column;
    }
    out << text.substr(begin, end - begin);
    column += end - begin;
    begin = end + 1;
  }
  out << '\n';
}

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

void print_doctor(std::ostream& out, const DoctorReport& report, bool colour) {
  std::vector<const Finding*> order;
  for (const Finding& finding : report.findings) order.push_back(&finding);
  std::stable_sort(order.begin(), order.end(),
                   [](const Finding* a, const Finding* b) { return rank(a->verdict) < rank(b->verdict); });
  const std::string indent(kIndent, ' ');
  for (const Finding* finding : order) {
    const std::string word = pad_right(to_string(finding->verdict), 8);
    out << (colour ? colour_of(finding->verdict) + word + "\033[0m" : word);
    out << pad_right(finding->name, kIndent - 8 - 1) << ' ';
    print_wrapped(out, finding->value);
    if (finding->verdict == Health::good || finding->verdict == Health::unknown) continue;
    out << indent;
    print_wrapped(out, finding->why);
    // In one piece, so that it can be copied.
    if (!finding->cure.empty()) out << indent << "cure: " << finding->cure << '\n';
  }
  const std::string summary = report.summary();
  out << (colour ? colour_of(report.verdict()) + summary + "\033[0m" : summary) << '\n';
}

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
