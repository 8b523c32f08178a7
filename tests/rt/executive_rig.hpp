// SPDX-License-Identifier: BSD-3-Clause
// Three groups that read each other, small enough to reason about: what every test of the executive runs.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "rt/executive.hpp"
#include "rt/mailbox.hpp"
#include "rt/virtual_runner.hpp"

namespace sortie::rt::test {

/// Output of every task of the rig.
struct Sum {
  std::uint64_t job{};
  std::uint64_t value{};

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("job", self.job);
    visit("value", self.value);
  }
};

/// Delays a job at random: what an operating system does to a thread.
class Jitter {
 public:
  /// What else may happen to a thread; called at every delay.
  using Disturbance = void (*)(std::minstd_rand& random);

  explicit Jitter(std::uint32_t seed, std::uint32_t most_us, Disturbance disturb = nullptr)
      : random_(seed), most_us_(most_us), disturb_(disturb) {}
  void delay() {
    if (disturb_ != nullptr) disturb_(random_);
    if (most_us_ == 0) return;
    std::this_thread::sleep_for(std::chrono::microseconds(random_() % (most_us_ + 1)));
  }

 private:
  std::minstd_rand random_;
  std::uint32_t most_us_;
  Disturbance disturb_;
};

/// fast (1 tick) <-> middle (5 ticks) <-> slow (20 ticks), each summing what it sees of its neighbours. With
/// `naive` the values cross in a newest-visible mailbox instead: the fault that logical execution time is
/// there to prevent.
class Rig {
 public:
  explicit Rig(std::uint32_t seed = 0, std::uint32_t most_us = 0, bool naive = false,
               Jitter::Disturbance disturb = nullptr)
      : memory_(4u << 20), arena_(memory_), executive(arena_, 1'000'000, 0) {
    const GroupId fast = executive.add_group({"fast", 1, 0, -1});
    const GroupId middle = executive.add_group({"middle", 5, 0, -1});
    const GroupId slow = executive.add_group({"slow", 20, 0, -1});
    for (std::uint32_t i = 0; i < 3; ++i)
      jitter_.push_back(std::make_unique<Jitter>(seed * 3 + i, most_us, disturb));
    fast_ = executive.add_task<Sum>(fast, "fast", 100, [this, naive](JobContext& context, Sum& sum) {
      step(context, sum, *jitter_[0], naive, 1, fast_input_);
    });
    middle_ = executive.add_task<Sum>(middle, "middle", 100, [this, naive](JobContext& context, Sum& sum) {
      step(context, sum, *jitter_[1], naive, 2, middle_input_);
    });
    slow_ = executive.add_task<Sum>(slow, "slow", 100, [this, naive](JobContext& context, Sum& sum) {
      step(context, sum, *jitter_[2], naive, 0, slow_input_);
    });
    fast_input_ = executive.add_input(fast, middle_, 4);
    middle_input_ = executive.add_input(middle, slow_, 4);
    slow_input_ = executive.add_input(slow, fast_, 40);
    sealed = executive.seal();
  }

 private:
  void step(JobContext& context, Sum& sum, Jitter& jitter, bool naive, std::uint32_t from,
            Input<Sum>* input) {
    jitter.delay();
    std::uint64_t seen = 0;
    if (naive) {
      Sum other;
      static_cast<void>(newest_[from].read(other));  // whatever is there now
      seen = other.value;
    } else {
      for (const Sum& other : *input) seen += other.value;
    }
    jitter.delay();
    sum.job = context.job;
    sum.value = sum.value * 31 + seen + context.job + 1;
    if (naive) newest_[(from + 2) % 3].write(sum);
  }

  std::vector<std::byte> memory_;
  Arena arena_;
  std::vector<std::unique_ptr<Jitter>> jitter_;
  Mailbox<Sum> newest_[3];
  Task<Sum>* fast_{};
  Task<Sum>* middle_{};
  Task<Sum>* slow_{};
  Input<Sum>* fast_input_{};
  Input<Sum>* middle_input_{};
  Input<Sum>* slow_input_{};

 public:
  Executive executive;
  Status sealed{};
};

/// Every release runs; nothing comes from outside.
class EveryRelease final : public JobFeed {
 public:
  bool prepare(std::uint32_t, std::uint64_t, Tick, JobOrder&) override { return true; }
};

/// Keeps every record of a run, by group.
class Recording {
 public:
  explicit Recording(Executive& executive) : jobs_(executive.group_count()) {
    executive.set_sink({this, [](void* self, const JobRecord& record) {
                          static_cast<Recording*>(self)->jobs_[record.group].push_back(record);
                        }});
  }
  const std::vector<JobRecord>& group(std::uint32_t index) const { return jobs_[index]; }

 private:
  std::vector<std::vector<JobRecord>> jobs_;
};

/// Gives a recording's jobs back: what was skipped stays skipped, what was missed stays missed.
class RecordedFeed final : public JobFeed {
 public:
  explicit RecordedFeed(const Recording& recording, std::uint32_t groups)
      : recording_(recording), next_(groups, 0) {}
  bool prepare(std::uint32_t group, std::uint64_t job, Tick, JobOrder& order) override {
    const auto& jobs = recording_.group(group);
    if (next_[group] >= jobs.size() || jobs[next_[group]].job != job) return false;
    order.recorded = &jobs[next_[group]++];
    return true;
  }

 private:
  const Recording& recording_;
  std::vector<std::size_t> next_;
};

}  // namespace sortie::rt::test
