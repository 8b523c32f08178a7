// SPDX-License-Identifier: BSD-3-Clause
// Queues of 64-byte messages between two threads on two cores, and within one thread. Every round holds one
// turn of every queue.
#include <thread>

#include "rt/posix/clock.hpp"
#include "tests/bench/rt/measure.hpp"
#include "tests/bench/rt/queue_peers.hpp"

namespace sortie::bench {

namespace {

constexpr int kPriority = 70;
constexpr std::uint32_t kPairs = 20000;
constexpr std::uint32_t kTrips = 20000;
constexpr std::uint32_t kMessages = 1u << 20;

void keep(Message& message) { asm volatile("" : : "r"(&message) : "memory"); }

double seconds_since(rt::Nanoseconds begin) {
  return static_cast<double>(rt::posix::monotonic_now() - begin) * 1e-9;
}

// ns per push and pop on one thread: nothing waits.
template <class Queue>
double single_ns(const Settings& settings) {
  const RealtimeSlice slice(settings, settings.core, kPriority);
  const auto queue = std::make_unique<Queue>();
  Message message;
  const rt::Nanoseconds begin = rt::posix::monotonic_now();
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    message.words[0] = i;
    keep(message);
    if (!queue->push(message) || !queue->pop(message)) return -1;
    keep(message);
  }
  return 1e9 * seconds_since(begin) / kPairs;
}

// ns from a push until the answer is back.
template <class Queue>
void round_trips(const Settings& settings, rt::LatencyHistogram& trips) {
  const auto there = std::make_unique<Queue>();
  const auto back = std::make_unique<Queue>();
  on_both_cores(
      settings, kPriority,
      [&] {
        Message message;
        for (std::uint32_t i = 0; i < kTrips; ++i) {
          const rt::Nanoseconds begin = rt::posix::monotonic_now();
          while (!there->push(message)) {
          }
          while (!back->pop(message)) {
          }
          trips.record(static_cast<std::uint64_t>(rt::posix::monotonic_now() - begin));
        }
      },
      [&] {
        Message message;
        for (std::uint32_t i = 0; i < kTrips; ++i) {
          while (!there->pop(message)) {
          }
          while (!back->push(message)) {
          }
        }
      });
}

// Million messages a second, in calls of `batch`.
template <class Queue>
double throughput(const Settings& settings, std::uint32_t batch) {
  const auto queue = std::make_unique<Queue>();
  double seconds = 0;
  on_both_cores(
      settings, kPriority,
      [&] {
        Message taken[kQueueBatch];
        const rt::Nanoseconds begin = rt::posix::monotonic_now();
        for (std::uint32_t i = 0; i < kMessages;) {
          i += batch == 1 ? static_cast<std::uint32_t>(queue->pop(taken[0])) : queue->pop_n(taken, batch);
          keep(taken[0]);
        }
        seconds = seconds_since(begin);
      },
      [&] {
        Message given[kQueueBatch];
        for (std::uint32_t i = 0; i < kMessages;) {
          keep(given[0]);
          i += batch == 1 ? static_cast<std::uint32_t>(queue->push(given[0])) : queue->push_n(given, batch);
        }
      });
  return 1e-6 * kMessages / seconds;
}

struct QueueRounds {
  const char* name{};
  Rounds single;
  Rounds one_by_one;
  Rounds batches;
  Rounds trip[3];
  rt::LatencyHistogram trips;
};

constexpr double kShares[] = {0.5, 0.99, 0.999};

void add_figure(Report& report, const std::string& what, const std::string& unit, std::uint64_t n,
                const Rounds& ours, const char* peer, const Rounds& theirs, const std::string& goal = {},
                double limit = 0, bool at_least = false) {
  const Rounds both = ratio(ours, theirs);
  Figure figure{"queue", what, unit, n, spread(ours), peer, spread(theirs), spread(both), {}, {}};
  if (!goal.empty()) set_goal(figure, goal, at_least ? both.median() >= limit : both.median() <= limit);
  report.add(figure);
}

}  // namespace

void measure_queues(const Settings& settings, Report& report) {
  say("queues");
#ifndef SORTIE_PEER_BOOST
  report.skip(
      "boost::lockfree::spsc_queue",
      "not there when this was built; apt-get install libboost-dev, then build sortie-bench-rt again");
#endif
  QueueRounds queues[kQueues];
  for (int round = 0; round < settings.rounds; ++round) {
    int index = 0;
    for_each_queue([&]<class Queue>() {
      QueueRounds& of = queues[index++];
      of.name = Queue::kName;
      std::thread([&] { of.single.add(single_ns<Queue>(settings)); }).join();
      if (settings.other_core < 0) return;
      rt::LatencyHistogram trips;
      round_trips<Queue>(settings, trips);
      of.trips.merge(trips);
      for (int i = 0; i < 3; ++i) of.trip[i].add(static_cast<double>(trips.percentile(kShares[i])));
      of.one_by_one.add(throughput<Queue>(settings, 1));
      of.batches.add(throughput<Queue>(settings, kQueueBatch));
    });
  }
  const QueueRounds& ours = queues[0];
  const auto rounds = static_cast<std::uint64_t>(settings.rounds);
  for (int i = 1; i < kQueues; ++i) {
    const QueueRounds& theirs = queues[i];
    const bool is_boost = kQueues == 3 && i == 1;
    add_figure(report, "push + pop, one thread", "ns", rounds * kPairs, ours.single, theirs.name,
               theirs.single);
    if (settings.other_core < 0) continue;
    const char* names[] = {"round trip p50", "round trip p99", "round trip p99.9"};
    for (int k = 0; k < 3; ++k) {
      add_figure(report, names[k], "ns", rounds * kTrips, ours.trip[k], theirs.name, theirs.trip[k],
                 is_boost && k == 0 ? "ratio <= 1" : "", 1);
    }
    add_figure(report, "one by one, two cores", "M/s", rounds * kMessages, ours.one_by_one, theirs.name,
               theirs.one_by_one);
    add_figure(report, "batches of 16, theirs one by one", "M/s", rounds * kMessages, ours.batches,
               theirs.name, theirs.one_by_one, is_boost ? "ratio >= 2" : "", 2, true);
    add_figure(report, "batches of 16, theirs too", "M/s", rounds * kMessages, ours.batches, theirs.name,
               theirs.batches);
  }
  if (settings.other_core < 0) report.skip("queues between two cores", "this process may use one core only");
}

}  // namespace sortie::bench
