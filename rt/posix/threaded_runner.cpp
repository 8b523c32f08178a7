// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/threaded_runner.hpp"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "rt/posix/make_thread.hpp"

namespace sortie::rt::posix {

namespace {

// One group's thread with room for exactly one job: no two overlap, as deadlines lie within the period.
class Worker {
 public:
  Worker(Executive& executive, std::uint32_t group)
      : executive_(executive),
        group_(group),
        thread_(make_thread("group " + std::string(executive.group(group).spec.name), [this] { loop(); })) {}
  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void start(std::uint64_t job, const JobOrder& order) {
    {
      const std::lock_guard lock(mutex_);
      job_ = job;
      order_ = order;
      busy_ = true;
    }
    changed_.notify_all();
  }
  void wait_until_decided() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
  }

 private:
  void loop() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return busy_ || stop_; });
      if (!busy_) return;
      lock.unlock();
      static_cast<void>(executive_.run_job(group_, job_, order_));  // the verdict stands in the record
      lock.lock();
      busy_ = false;
      changed_.notify_all();
    }
  }

  Executive& executive_;
  std::uint32_t group_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t job_{};
  JobOrder order_{};
  bool busy_{};
  bool stop_{};
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace

void run_virtual_threaded(Executive& executive, JobFeed& feed, Tick first, Tick last) {
  std::vector<std::unique_ptr<Worker>> workers;
  std::vector<Tick> due(executive.group_count(), 0);
  for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
    workers.push_back(std::make_unique<Worker>(executive, index));
  }
  for (Tick tick = first; tick <= last; ++tick) {
    for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
      if (due[index] != 0 && due[index] <= tick) {
        workers[index]->wait_until_decided();
        due[index] = 0;
      }
    }
    feed.before_tick(tick);
    for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
      Group& group = executive.group(index);
      if (!group.timing.releases_at(tick)) continue;
      const std::uint64_t job = group.timing.job_at(tick);
      JobOrder order;
      if (feed.prepare(index, job, tick, order)) {
        workers[index]->start(job, order);
        due[index] = group.timing.due(job);
      } else {
        ++group.skipped;
        group.misses.note(false);
      }
    }
  }
  for (auto& worker : workers) worker->wait_until_decided();
}

}  // namespace sortie::rt::posix
