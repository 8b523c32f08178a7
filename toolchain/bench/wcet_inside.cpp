// SPDX-License-Identifier: BSD-3-Clause
// The counted side: between two marks lies one task's job and nothing else.
#include <algorithm>
#include <fstream>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/log/named_fault.hpp"
#include "firmware_like/log/replay.hpp"
#include "toolchain/bench/instruction_count.hpp"
#include "toolchain/bench/wcet.hpp"

namespace sortie::toolchain {

namespace {

struct MarkedJob {
  const rt::TaskBase* task{};
  rt::Tick tick{};
};

struct Marks {
  std::vector<MarkedJob> jobs;
  const rt::TaskBase* slow_task{};
  rt::Tick slow_tick{};
};

[[gnu::noinline]] void probe(void* self, const rt::TaskBase& task, rt::Tick tick, bool entering) {
  auto& marks = *static_cast<Marks*>(self);
  if (!entering) {
    mark_count();
    return;
  }
  marks.jobs.push_back({&task, tick});
  const bool slow = marks.slow_task == &task && marks.slow_tick == tick;
  mark_count();
  if (slow) {
    for (int turn = 0; turn < 1000; ++turn) asm volatile("");
  }
}

}  // namespace

void replay_counted(const firmware::VehicleRegistry& vehicles, const WcetOptions& options,
                    const std::string& jobs_file) {
  const firmware::LogFile log(options.log);
  Marks marks;
  marks.jobs.reserve(std::size_t{1} << 20);
  firmware::ReplayOptions replaying;
  replaying.scene = options.scene;
  replaying.overrides = options.overrides;
  replaying.maps = options.maps;
  replaying.before_run = [&marks, &options](firmware::Runtime& runtime) {
    rt::Executive& executive = runtime.executive();
    if (!options.fault.empty()) {
      const firmware::NamedFault fault = firmware::parse_fault(executive, options.fault, false);
      marks.slow_task = &executive.task(fault.task);
      marks.slow_tick = fault.tick;
    }
    executive.set_record_fields(false);  // as in a live run
    executive.set_clock(nullptr, nullptr);
    start_counting();
    // A pair of marks with nothing between tells what a pair adds; the first one warms up.
    for (int i = 0; i < 2; ++i) {
      void (*volatile call)(void*, const rt::TaskBase&, rt::Tick, bool) = probe;
      call(&marks, executive.task(0), ~rt::Tick{0}, true);
      call(&marks, executive.task(0), ~rt::Tick{0}, false);
    }
    executive.set_task_probe(probe, &marks);
  };
  const firmware::ReplayOutcome outcome = firmware::replay(log, vehicles, replaying);
  const auto is_slow = [&marks](const MarkedJob& job) {
    return job.task == marks.slow_task && job.tick == marks.slow_tick;
  };
  if (marks.slow_task != nullptr && std::ranges::none_of(marks.jobs, is_slow))
    firmware::refuse_unmet_fault(options.fault);

  const rt::Executive& executive = outcome.runtime->executive();
  std::ofstream out(jobs_file);
  out << outcome.results.scene << "\n" << executive.task_count() << "\n";
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const rt::TaskBase& task = executive.task(i);
    out << task.name() << " " << executive.group(task.group()).spec.name << " " << task.budget_us() << "\n";
  }
  for (const MarkedJob& job : marks.jobs) {
    std::uint32_t index = 0;
    while (&executive.task(index) != job.task) ++index;
    out << index << " " << job.tick << "\n";
  }
  if (!out.flush()) throw std::runtime_error(jobs_file + ": cannot be written");
}

}  // namespace sortie::toolchain
