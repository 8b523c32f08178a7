// SPDX-License-Identifier: BSD-3-Clause
// Delays that are made on purpose, and which cause they are given: the confusion table.
#include <sys/wait.h>
#include <unistd.h>

#include "tests/bench/rt/measure.hpp"
#include "tests/rt/cause_confusion.hpp"

namespace sortie::bench {

namespace {

using namespace rt::posix::test;

// In a process of its own: every run begins with an observer that has seen nothing.
bool run_rig(Injection injection, std::uint32_t seed, double seconds, RigResult& result) {
  const pid_t child = fork();
  if (child == 0) {
    CauseRig(injection, seed, seconds, result).run();
    _exit(0);
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

void measure_causes(const Settings& settings, Report& report) {
  say("causes of delays that are made on purpose");
  if (!settings.realtime || settings.other_core < 0) {
    report.skip("causes of delays", settings.realtime ? "this needs two cores" : "this needs SCHED_FIFO");
    return;
  }
  const double seconds = std::max(2.0, settings.slice_s * settings.rounds * 0.4);
  for (const Injection injection :
       {Injection::hog, Injection::own_work, Injection::signals, Injection::pause}) {
    SharedResult result;
    if (!run_rig(injection, 7, seconds, *result) || result->refused[0] != '\0') {
      report.skip(to_string(injection), result->refused[0] != '\0' ? result->refused : "the run failed");
      continue;
    }
    const ConfusionRow row = judge(*result);
    const std::uint32_t right = row.label[static_cast<int>(truth_of(injection))];
    Figure figure;
    figure.group = "causes";
    figure.what = std::string(to_string(injection)) + ", told right";
    figure.unit = "%";
    figure.n = row.outliers;
    const double share = row.outliers == 0 ? 0 : 100.0 * right / row.outliers;
    figure.ours = spread(share);
    if (row.outliers >= 20) set_goal(figure, ">= 95 %", share >= 95);
    report.add(figure);
    Json labels;
    std::string words = std::string(to_string(injection)) + ", " + std::to_string(row.outliers) + " late:";
    for (int i = 0; i < rt::posix::kDelayCauses; ++i) {
      const char* name = to_string(static_cast<rt::posix::DelayCause>(i));
      labels[name] = row.label[i];
      words += std::string(i == 0 ? " " : ", ") + name + " " + std::to_string(row.label[i]);
    }
    report.root()["confusion"].push_back({{"injected", to_string(injection)},
                                          {"injections", row.injected},
                                          {"late", row.outliers},
                                          {"labels", labels}});
    report.note("causes", words);
  }
}

}  // namespace sortie::bench
