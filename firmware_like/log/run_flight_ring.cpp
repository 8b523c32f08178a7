// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/run_flight_ring.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "firmware_like/log/flight_ending.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "rt/posix/file_place.hpp"
#include "rt/posix/flight_reader.hpp"

namespace sortie::firmware {
namespace {

constexpr std::size_t kMostKept = 4;
const char* const kThreads[] = {"devices", "bench"};

/// A folder in memory that this user may write to, or nothing.
std::string memory_folder() {
  const char* runtime_folder = std::getenv("XDG_RUNTIME_DIR");
  for (const char* folder : {runtime_folder, "/dev/shm"}) {
    if (folder == nullptr || *folder == '\0') continue;
    const int file = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) continue;
    const bool good = rt::posix::on_memory_file_system(file) && access(folder, W_OK) == 0;
    close(file);
    if (good) return folder;
  }
  return {};
}

/// How the run ended whose ring this is; empty when it cannot be read.
std::string ending_in(const std::string& path) {
  try {
    return "an earlier run did not end by itself: " + ending_of(rt::posix::FlightReader(path));
  } catch (const std::exception&) {
    return {};
  }
}

rt::posix::FlightPlan plan_of(const Runtime& runtime, std::uint32_t ticks) {
  const rt::Executive& executive = runtime.executive();
  rt::posix::FlightPlan plan;
  plan.ticks = ticks;
  rt::posix::FlightHeader& header = plan.header;
  rt::posix::copy_text(header.scene, runtime.profile().name());
  rt::posix::copy_text(header.vehicle, runtime.profile().vehicle());
  rt::posix::copy_text(header.version_text, version());
  header.scene_hash = runtime.profile().hash();
  header.base_tick_ns = executive.base_tick_ns();
  header.epoch_ns = executive.epoch_ns();
  header.groups = executive.group_count();
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    const rt::Group& group = executive.group(i);
    rt::posix::FlightGroup& entry = header.group[i];
    rt::posix::copy_text(entry.name, group.spec.name);
    entry.period_ticks = group.timing.period;
    entry.phase_ticks = group.timing.phase;
    entry.deadline_ticks = group.timing.deadline;
    entry.core = group.spec.core;
    for (const rt::TaskBase* task : group.tasks) {
      rt::posix::copy_text(entry.task[entry.tasks], task->name());
      entry.budget_us[entry.tasks++] = task->budget_us();
    }
  }
  plan.more_tracks.assign(std::begin(kThreads), std::end(kThreads));
  return plan;
}

// Removes what starts that died within the making of a ring have left in `folder`: parts that no process
// writes.
void remove_abandoned_parts(const std::string& folder) {
  std::error_code error;
  std::filesystem::directory_iterator it(folder, error);
  for (const std::filesystem::directory_iterator end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.rfind("sortie-", 0) != 0 || it->path().extension() != ".part") continue;
    const int file = open(it->path().c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0) unlink(it->path().c_str());
    close(file);
  }
}

}  // namespace

RunFlightRing::RunFlightRing(Runtime& runtime, const FlightRingOptions& options, bool simulated_time)
    : runtime_(runtime) {
  if (options.path == "none" || (options.path == "auto" && simulated_time)) return;
  std::string path = options.path;
  if (path == "auto") {
    const std::string folder = memory_folder();
    if (folder.empty()) {
      warnings_.emplace_back(
          "no flight ring is kept: there is no /dev/shm here; mount one, or give --flight-ring FILE or none");
      return;
    }
    const std::vector<std::string> left = unfinished_flight_rings(folder);
    if (!left.empty()) {
      before_this_ = ending_in(left.front());
      warnings_.push_back("an earlier run did not end by itself; its last moments: sortie export jobs " +
                          left.front() + " (remove the file when you have seen it)");
    }
    for (std::size_t i = kMostKept; i < left.size(); ++i) unlink(left[i].c_str());
    remove_abandoned_parts(folder);
    path = folder + "/sortie-" + runtime.profile().name() + "-" + std::to_string(getpid()) + ".ring";
    own_file_ = true;
  }
  rt::posix::FlightPlan plan = plan_of(runtime, options.ticks);
  plan.waits = !own_file_;  // nothing can stand where this process's own ring goes
  try {
    ring_ = std::make_unique<rt::posix::FlightRing>(path, plan);
    if (!own_file_ && rt::posix::FlightReader::was_left(path)) before_this_ = ending_in(path);
  } catch (const std::runtime_error& error) {
    if (!own_file_) throw;
    warnings_.emplace_back(error.what());
    return;
  }
  warnings_.insert(warnings_.end(), ring_->warnings().begin(), ring_->warnings().end());
  crash_ = std::make_unique<rt::posix::CrashNote>(*ring_);
  for (std::uint32_t i = 0; i < runtime.executive().group_count(); ++i) {
    rt::Group& group = runtime.executive().group(i);
    running_before_.push_back(group.running);
    group.running = ring_->running(i);  // so that the file tells which task a process died in
  }
}

RunFlightRing::~RunFlightRing() {
  for (std::uint32_t i = 0; i < running_before_.size(); ++i)
    runtime_.executive().group(i).running = running_before_[i];
  if (ring_ && next_.call != nullptr) runtime_.executive().set_sink(next_);
  if (ring_ && own_file_) unlink(ring_->path().c_str());  // whoever gets here has not crashed
}

void RunFlightRing::set_clock(rt::Nanoseconds start_ns, rt::Nanoseconds utc_minus_monotonic_ns) {
  if (ring_) ring_->set_clock(start_ns, utc_minus_monotonic_ns);
}

void RunFlightRing::first_job() {
  if (!ring_ || in_place_) return;
  in_place_ = true;
  place_problem_ = ring_->take_place();
}

rt::JobSink RunFlightRing::before(rt::JobSink next) {
  if (!ring_) return next;
  next_ = next;
  return {this, [](void* self, const rt::JobRecord& record) {
            auto* both = static_cast<RunFlightRing*>(self);
            both->ring_->job(record);
            both->next_.call(both->next_.self, record);
          }};
}

void RunFlightRing::event(rt::Nanoseconds time_ns, rt::Tick tick, std::string_view text) {
  if (ring_) ring_->event(time_ns, tick, text);
}

void RunFlightRing::adopt_thread(std::string_view name) {
  if (!ring_) return;
  const auto found = std::find(std::begin(kThreads), std::end(kThreads), name);
  if (found == std::end(kThreads)) return;
  rt::posix::this_thread_spans = &ring_->track(runtime_.executive().group_count() +
                                               static_cast<std::uint32_t>(found - std::begin(kThreads)));
}

void RunFlightRing::finish(rt::Nanoseconds time_ns) {
  if (!ring_) return;
  ring_->finish(time_ns);
}

std::vector<std::string> unfinished_flight_rings(const std::string& folder) {
  std::vector<std::pair<std::filesystem::file_time_type, std::string>> found;
  std::error_code error;
  std::filesystem::directory_iterator it(folder, error);
  for (const std::filesystem::directory_iterator end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.rfind("sortie-", 0) != 0 || it->path().extension() != ".ring") continue;
    if (!rt::posix::FlightReader::was_left(it->path().string())) continue;
    std::error_code ignored;
    found.emplace_back(std::filesystem::last_write_time(it->path(), ignored), it->path().string());
  }
  std::sort(found.rbegin(), found.rend());
  std::vector<std::string> paths;
  paths.reserve(found.size());
  for (auto& [time, path] : found) paths.push_back(std::move(path));
  return paths;
}

}  // namespace sortie::firmware
