// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/doctor/doctor.hpp"

#include <time.h>

#include <algorithm>
#include <cstdio>

#include "firmware_like/doctor/checks.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "rt/posix/make_thread.hpp"
#include "rt/posix/realtime.hpp"

namespace sortie::firmware {
namespace {

std::vector<int> online_cores(const MachineFiles& files) {
  std::vector<int> cores = parse_core_list(files.read("/sys/devices/system/cpu/online").value_or(""));
  if (cores.empty()) {
    for (const auto& [number, core] : read_counters(files).cores) cores.push_back(number);
  }
  return cores;
}

std::int64_t resolution_of(clockid_t clock) {
  timespec step{};
  return clock_getres(clock, &step) == 0 ? std::int64_t{step.tv_sec} * 1'000'000'000 + step.tv_nsec : 0;
}

/// A thread of its own asks, so that nothing of this process is changed.
bool ask_for_fifo() {
  bool granted = false;
  rt::posix::make_thread("the doctor's trial", [&granted] {
    granted = rt::posix::set_fifo_priority(1).ok;
  }).join();
  return granted;
}

using Question = Finding (*)(const BoardView&);
constexpr Question kQuestions[] = {
    check_realtime_priority, check_memory_lock, check_preempt_rt,  check_clock_source,
    check_rt_throttling,     check_fair_server, check_governor,    check_isolated_cores,
    check_timer_tick,        check_interrupts,  check_smt_sibling, check_cpu_dma_latency,
    check_huge_pages,        check_swap,        check_heat,        check_hypervisor,
};

}  // namespace

Doctor::Doctor(const DoctorOptions& options)
    : files_(options.root), options_(options), first_(read_counters(files_)) {
  const std::vector<int> cores = online_cores(files_);
  if (options.core >= 0 && std::find(cores.begin(), cores.end(), options.core) == cores.end()) {
    throw InputError(
        "--core " + std::to_string(options.core) + ": this machine has cores " + describe_cores(cores), 2);
  }
}

DoctorReport Doctor::report() const {
  BoardView board;
  board.files = files_;
  board.since_boot = read_counters(files_);
  board.window = difference(board.since_boot, first_);
  if (board.window.time_s < 0.05) board.window = {};
  board.cores = online_cores(files_);
  board.core = options_.core;
  std::sscanf(files_.read("/proc/sys/kernel/osrelease").value_or("").c_str(), "%d.%d", &board.kernel_major,
              &board.kernel_minor);
  if (files_.is_own()) {
    board.tick_ns = resolution_of(CLOCK_MONOTONIC_COARSE);
    board.timer_resolution_ns = resolution_of(CLOCK_MONOTONIC);
    board.fifo_granted = ask_for_fifo();
  }
  DoctorReport report;
  report.present = true;
  report.machine = files_.is_own() ? machine_description() : "files below " + options_.root;
  for (const Question question : kQuestions) report.findings.push_back(question(board));
  return report;
}

}  // namespace sortie::firmware
