// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_jobs.hpp"

#include <signal.h>
#include <sys/wait.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <map>

#include "firmware_like/live/stop_signals.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "rt/posix/clock.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/sweep/sweep_work.hpp"

namespace sortie::toolchain {

namespace {

double seconds_since(rt::Nanoseconds begin) { return rt::to_seconds(rt::posix::monotonic_now() - begin); }

struct Running {
  std::size_t cell{};
  rt::Nanoseconds begin{};
};

void end_all(const std::map<pid_t, Running>& running) {
  for (const auto& [child, unused] : running) kill(child, SIGTERM);
  for (const auto& [child, unused] : running) {
    while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
}

// The first of the processes that has ended: its place and whether it ended well.
std::map<pid_t, Running>::iterator find_ended(std::map<pid_t, Running>& running, bool& good) {
  for (auto entry = running.begin(); entry != running.end(); ++entry) {
    int status = 0;
    if (waitpid(entry->first, &status, WNOHANG) != entry->first) continue;
    good = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    return entry;
  }
  return running.end();
}

}  // namespace

SweepJobsEnd run_sweep_jobs(const SweepFolderPlan& plan, const SweepJobsOptions& options) {
  SweepJobsEnd end;
  std::vector<std::size_t> waiting;
  for (const std::size_t cell : options.cells) {
    if (read_cell(options.folder, cell, plan)) {
      ++end.taken;
      continue;
    }
    if (std::filesystem::exists(options.folder + "/" + cell_file(cell))) ++end.stale;
    waiting.push_back(cell);
  }
  const std::size_t all = waiting.size();
  const std::string program = own_program_path();
  const firmware::StopSignals watch;
  const rt::Nanoseconds begin = rt::posix::monotonic_now();
  std::map<pid_t, Running> running;
  std::size_t next = 0;
  std::size_t done = 0;
  while (done < all) {
    if (firmware::StopSignals::asked()) {
      end_all(running);
      end.signal = firmware::StopSignals::number();
      return end;
    }
    if (next < all && running.size() < std::max<std::size_t>(1, options.jobs)) {
      try {
        const Running one{waiting[next], rt::posix::monotonic_now()};
        const std::string number = std::to_string(one.cell);
        running[start_child({{program, "bench", "--cell", number, "--out", options.folder}, {}})] = one;
      } catch (...) {
        end_all(running);
        throw;
      }
      ++next;
      continue;
    }
    bool good = false;
    const auto ended = find_ended(running, good);
    if (ended == running.end()) {
      constexpr timespec kPause{0, 10'000'000};
      nanosleep(&kPause, nullptr);
      continue;
    }
    const Running cell = ended->second;
    running.erase(ended);
    ++done;
    if (!good) end.failed.push_back(cell.cell);
    const double left_s = seconds_since(begin) / static_cast<double>(done) * static_cast<double>(all - done);
    if (options.on_cell) options.on_cell(done, all, cell.cell, seconds_since(cell.begin), left_s);
  }
  std::sort(end.failed.begin(), end.failed.end());
  return end;
}

void run_sweep_cell(const std::string& folder, std::size_t cell, const firmware::VehicleRegistry& vehicles) {
  const SweepFolderPlan plan = read_plan(folder);
  if (cell >= plan.cell_count()) {
    throw firmware::InputError(folder + "/plan.json: has no cell " + std::to_string(cell) + "; it has 0 to " +
                                   std::to_string(plan.cell_count() - 1),
                               2);
  }
  const std::string cure = "; start the sweep again, so that no cell is compared with what it is not";
  if (digest_of_file(own_program_path()) != plan.program)
    throw firmware::InputError(own_program_path() + ": is not the program that planned " + folder + cure);
  const auto [l, c] = plan.locate(cell);
  const PlannedLog& planned = plan.logs[l];
  if (!planned.simulated && digest_of_file(planned.path) != planned.identity)
    throw firmware::InputError(planned.path + ": is not the log that " + folder + " was planned with" + cure);
  if (read_cell(folder, cell, plan)) return;
  const firmware::LogFile log(planned.path);
  SweepCellResult result;
  result.cell = planned.plan.sweep.cells[c];
  SweepWork work(planned.plan.overrides[c], planned.plan.sweep.tasks);
  const SweepOptions options = sweep_options(plan.request);
  for (std::uint32_t i = 0; i < planned.plan.sweep.repeat; ++i)
    result.duration_s = work.replay_once(log, vehicles, options.replay, options.evaluation, result.cell);
  work.take_times(result.duration_s, result.cell);
  if (plan.request.instructions) work.count_instructions(log, options.replay, result.duration_s, result.cell);
  result.map = work.map();
  write_cell(folder, cell, plan.key(cell), result);
}

std::vector<std::size_t> shard_cells(std::size_t cells, std::size_t i, std::size_t n) {
  std::vector<std::size_t> own;
  for (std::size_t cell = i - 1; cell < cells; cell += n) own.push_back(cell);
  return own;
}

}  // namespace sortie::toolchain
