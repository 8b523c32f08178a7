// SPDX-License-Identifier: BSD-3-Clause
// System calls of every worker, counted from outside: a child runs the live runner, this process stops it at
// each call.
#include <signal.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <map>
#include <memory>

#include "rt/arena.hpp"
#include "rt/executive.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/live_runner.hpp"
#include "rt/samples.hpp"
#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

namespace {

constexpr rt::Tick kTicks = 1000;
// Asked for on a worker before its first and after its last job: the kernel refuses them, the tracer sees
// them.
constexpr long kBegin = 0x5254'0001;
constexpr long kEnd = 0x5254'0002;

// The child: two groups of empty tasks, 1 kHz and 200 Hz, on the live runner.
[[noreturn]] void run_traced(const Settings& settings, bool attribution) {
  std::vector<std::byte> memory(std::size_t{8} << 20);
  rt::Arena arena(memory);
  rt::Executive executive(arena, rt::kNanosecondsPerMillisecond, 0);
  const auto work = [](rt::JobContext& context, rt::PoseEstimate& pose) {
    pose.stamp_ns = context.release_ns;
  };
  executive.add_task<rt::PoseEstimate>(executive.add_group({"fast", 1, 0, -1}), "fast", 100, work);
  executive.add_task<rt::PoseEstimate>(executive.add_group({"slow", 5, 0, -1}), "slow", 100, work);
  if (executive.seal() != Status::ok) _exit(3);
  ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
  raise(SIGSTOP);
  static rt::Nanoseconds start = 0;
  start = rt::posix::monotonic_now() + 100 * rt::kNanosecondsPerMillisecond;
  executive.set_clock([](void*) { return rt::posix::monotonic_now() - start; }, nullptr);
  rt::posix::LiveOptions options;
  options.start_ns = start;
  options.last_tick = kTicks - 1;
  options.realtime = settings.realtime;
  options.attribution = attribution;
  options.delay_threshold_ns =
      3600 * rt::kNanosecondsPerSecond;  // every job is late under a tracer; late ones ask more
  options.on_worker = [](bool starts) { prctl(static_cast<int>(starts ? kBegin : kEnd), 0, 0, 0, 0); };
  rt::posix::LiveRunner runner(executive, options);
  runner.start();
  runner.join();
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    // The tracer reads how many jobs there were as the arguments of one more refused call.
    prctl(static_cast<int>(kEnd + 1 + i), static_cast<unsigned long>(executive.group(i).jobs), 0, 0, 0);
  }
  _exit(0);
}

struct ThreadCount {
  std::string name;
  bool counting{};
  bool is_worker{};
  std::map<std::uint64_t, std::uint64_t> calls;
};

std::string thread_name(pid_t process, pid_t thread) {
  std::ifstream in("/proc/" + std::to_string(process) + "/task/" + std::to_string(thread) + "/comm");
  std::string name;
  std::getline(in, name);
  return name;
}

struct Counted {
  std::map<pid_t, ThreadCount> threads;
  std::uint64_t jobs[2]{};
  std::string problem;
};

void note_call(pid_t child, pid_t thread, Counted& counted) {
  __ptrace_syscall_info info{};
  if (ptrace(PTRACE_GET_SYSCALL_INFO, thread, sizeof info, &info) <= 0) {
    counted.problem = "PTRACE_GET_SYSCALL_INFO: refused; needs Linux 5.3";
    return;
  }
  if (info.op != PTRACE_SYSCALL_INFO_ENTRY) return;
  ThreadCount& of = counted.threads[thread];
  const auto mark = static_cast<long>(info.entry.args[0] & 0xffffffffu);
  if (info.entry.nr == SYS_prctl && mark == kBegin) {
    of.name = thread_name(child, thread);
    of.is_worker = of.counting = true;
  } else if (info.entry.nr == SYS_prctl && mark == kEnd) {
    of.counting = false;
  } else if (info.entry.nr == SYS_prctl && (mark == kEnd + 1 || mark == kEnd + 2)) {
    counted.jobs[mark - kEnd - 1] = info.entry.args[1];
  } else if (of.counting) {
    ++of.calls[info.entry.nr];
  }
}

Counted count_calls(const Settings& settings, bool attribution) {
  Counted counted;
  const pid_t child = fork();
  if (child == 0) run_traced(settings, attribution);
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) {
    counted.problem = "a child could not be traced; ptrace may be forbidden here (seccomp, Yama)";
    return counted;
  }
  constexpr long kOptions = PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL;
  if (ptrace(PTRACE_SETOPTIONS, child, nullptr, kOptions) != 0)
    counted.problem = "PTRACE_SETOPTIONS: refused";
  ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
  while (true) {
    const pid_t thread = waitpid(-1, &status, __WALL);
    if (thread < 0) break;
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      if (thread == child) break;
      continue;
    }
    const int signal = WSTOPSIG(status);
    if (signal == (SIGTRAP | 0x80)) note_call(child, thread, counted);
    // A new thread's first stop and the tracer's own events are not for the child.
    const bool own = signal == (SIGTRAP | 0x80) || signal == SIGTRAP || signal == SIGSTOP;
    ptrace(PTRACE_SYSCALL, thread, nullptr, own ? 0L : static_cast<long>(signal));
  }
  if (counted.jobs[0] == 0 && counted.problem.empty())
    counted.problem = "the traced run did not end by itself";
  return counted;
}

}  // namespace

void measure_system_calls(const Settings& settings, Report& report) {
  say("system calls of the workers");
  for (const bool attribution : {false, true}) {
    const Counted counted = count_calls(settings, attribution);
    if (!counted.problem.empty()) {
      report.skip("system calls", counted.problem);
      return;
    }
    const std::uint64_t allowed = attribution ? 2 : 1;
    for (const auto& [id, thread] : counted.threads) {
      if (!thread.is_worker) continue;
      std::uint64_t all = 0;
      Json calls;
      for (const auto& [call, count] : thread.calls) {
        all += count;
        calls[std::to_string(call)] = count;
      }
      const std::uint64_t jobs = counted.jobs[thread.name == "fast" ? 0 : 1];
      Figure figure{"system calls",
                    "worker '" + thread.name + "', a job" + (attribution ? ", delays explained" : ""),
                    "",
                    jobs,
                    {},
                    {},
                    {},
                    {},
                    {},
                    {}};
      figure.ours = spread(static_cast<double>(all) / static_cast<double>(jobs == 0 ? 1 : jobs));
      // A release that is left out was slept for, too.
      set_goal(figure, "<= " + std::to_string(allowed),
               all <= allowed * kTicks / (thread.name == "fast" ? 1 : 5) + 2);
      report.add(figure);
      report.root()["system_calls"].push_back(
          {{"worker", thread.name}, {"attribution", attribution}, {"jobs", jobs}, {"calls", calls}});
    }
  }
}

}  // namespace sortie::bench
