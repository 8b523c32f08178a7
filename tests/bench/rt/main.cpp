// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-rt: measures the real-time ground beside its peers and prints one JSON object. `sortie bench
// rt` runs it and shows the table.
#include <sys/utsname.h>
#include <unistd.h>

#include <future>
#include <iostream>
#include <stdexcept>
#include <thread>

#include "rt/posix/fast_clock.hpp"
#include "rt/posix/realtime.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/rt/measure.hpp"
#include "toolchain/bench/child_process.hpp"

namespace sortie::bench {

namespace {

struct Part {
  const char* name;
  void (*measure)(const Settings&, Report&);
};
constexpr Part kParts[] = {{"wake", measure_wake},
                           {"queue", measure_queues},
                           {"count", measure_queue_instructions},
                           {"mailbox", measure_mailboxes},
                           {"executive", measure_executive},
                           {"calls", measure_system_calls},
                           {"cause", measure_causes},
                           {"load", measure_load}};

struct Arguments {
  Settings settings;
  std::string only;
  bool counted_queues{};
};

Arguments parse(int argc, char** argv) {
  Arguments all;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : nullptr;
    if (option == "--counted-queues") {
      all.counted_queues = true;
      continue;
    }
    ++i;
    if (option == "--rounds")
      all.settings.rounds = static_cast<int>(number("--rounds", value, 1, 1e6));
    else if (option == "--slice")
      all.settings.slice_s = number("--slice", value, 0.05, 3600);
    else if (option == "--core")
      all.settings.core = static_cast<int>(number("--core", value, 0, 1023));
    else if (option == "--load")
      all.settings.load = static_cast<int>(number("--load", value, 0, 1024));
    else if (option == "--only" && value != nullptr)
      all.only = value;
    else
      throw std::invalid_argument("unknown option " + option);
  }
  return all;
}

// A refused right is found here once, on a thread of its own.
bool may_be_realtime(Report& report) {
  bool granted = false;
  std::thread([&] {
    const rt::posix::SetupResult fifo = rt::posix::set_fifo_priority(80);
    granted = fifo.ok;
    if (!fifo.ok) report.skip("SCHED_FIFO", fifo.reason);
  }).join();
  if (const rt::posix::SetupResult locked = rt::posix::lock_memory(); !locked.ok)
    report.skip("locked memory", locked.reason);
  return granted;
}

void choose_cores(Settings& settings, Report& report) {
  const int cores = rt::posix::usable_cores();
  if (settings.core < 0) settings.core = cores - 1;
  std::thread([&] {
    if (const rt::posix::SetupResult pinned = rt::posix::pin_to_core(settings.core); !pinned.ok)
      report.skip("pinning", pinned.reason);
  }).join();
  if (cores > 1) settings.other_core = settings.core == 0 ? 1 : 0;
}

int run(const Arguments& arguments) {
  Settings settings = arguments.settings;
  settings.program = toolchain::own_program_path();
  Report report;
  Json& root = report.root();
  root["load_before"] = load_average();
  root["figures"] = Json::array();
  root["distributions"] = Json::array();
  root["skipped"] = Json::array();
  root["notes"] = Json::array();
  rt::posix::start_fast_clock();
  settings.realtime = may_be_realtime(report);
  choose_cores(settings, report);
  root["settings"] = {{"rounds", settings.rounds},
                      {"slice_s", settings.slice_s},
                      {"core", settings.core},
                      {"load", settings.load},
                      {"realtime", settings.realtime}};
  // The C library takes its locks without atomic operations while a process has one thread: no robot's has.
  std::promise<void> end;
  std::thread other([waits = end.get_future()] { waits.wait(); });
  say("noise floor");
  root["noise"]["before"] = measure_noise(settings);
  bool found = arguments.only.empty();
  for (const Part& part : kParts) {
    if (!arguments.only.empty() && arguments.only != part.name) continue;
    found = true;
    part.measure(settings, report);
  }
  say("noise floor again");
  root["noise"]["after"] = measure_noise(settings);
  root["load_after"] = load_average();
  end.set_value();
  other.join();
  if (!found)
    throw std::invalid_argument("--only takes wake, queue, count, mailbox, executive, calls, cause or load");
  std::cout << root.dump() << std::endl;
  return 0;
}

}  // namespace

}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-rt", [argc, argv] {
    const sortie::bench::Arguments arguments = sortie::bench::parse(argc, argv);
    return arguments.counted_queues ? sortie::bench::run_counted_queues() : sortie::bench::run(arguments);
  });
}
