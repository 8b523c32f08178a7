// SPDX-License-Identifier: BSD-3-Clause
// Instructions of a push and a pop, exact: this program again, under callgrind.
#include "tests/bench/report/counted_child.hpp"
#include "tests/bench/rt/measure.hpp"
#include "tests/bench/rt/queue_peers.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {

namespace {

constexpr std::uint32_t kPairs = 10000;

// What the loop below costs by itself.
struct NoQueue {
  bool push(const Message& message) { return keep(&message); }
  bool pop(Message& message) { return keep(&message); }
  std::uint32_t push_n(const Message* messages, std::uint32_t n) { return keep(messages) ? n : 0; }
  std::uint32_t pop_n(Message* messages, std::uint32_t n) { return keep(messages) ? n : 0; }
  static bool keep(const Message* message) {
    asm volatile("" : : "r"(message) : "memory");
    return true;
  }
};

// A function of its own with a queue of its own, used as a program would: what was put in and taken out
// counts.
template <class Queue>
[[gnu::noinline]] std::uint64_t pairs(std::uint32_t count) {
  static Queue queue;
  Message message;
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    message.words[0] = i;
    if (!queue.push(message) || !queue.pop(message)) return 0;
    sum += message.words[0];
  }
  return sum;
}

template <class Queue>
[[gnu::noinline]] std::uint64_t batches(std::uint32_t count) {
  static Queue queue;
  Message messages[kQueueBatch];
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < count; i += kQueueBatch) {
    messages[0].words[0] = i;
    if (queue.push_n(messages, kQueueBatch) != kQueueBatch ||
        queue.pop_n(messages, kQueueBatch) != kQueueBatch)
      return 0;
    sum += messages[0].words[0];
  }
  return sum;
}

}  // namespace

int run_counted_queues() {
  toolchain::start_counting();
  const auto count = []<class Queue>() {
    // Round the ring once before, so that every page is there.
    std::uint64_t sum = pairs<Queue>(kQueueSlots + 16) + batches<Queue>(kQueueSlots);
    toolchain::mark_count();
    sum += pairs<Queue>(kPairs);
    toolchain::mark_count();
    sum += batches<Queue>(kPairs);
    toolchain::mark_count();
    asm volatile("" : : "r"(sum));
  };
  for_each_queue(count);
  count.operator()<NoQueue>();
  return 0;
}

void measure_queue_instructions(const Settings& settings, Report& report) {
  say("instructions of a push and a pop");
  const Marks counted = count_instructions({settings.program, "--counted-queues"});
  const std::vector<std::uint64_t>& marks = counted.instructions;
  if (!counted.why_none.empty() || marks.size() != std::size_t{3} * (kQueues + 1)) {
    report.skip("instructions of queues", counted.why_none.empty() ? "marks are missing" : counted.why_none);
    return;
  }
  const auto with_loop = [&marks](int queue, std::size_t mark) {
    const std::size_t at = static_cast<std::size_t>(queue) * 3 + mark;
    return static_cast<double>(marks[at + 1] - marks[at]) / kPairs;
  };
  const auto per_pair = [&with_loop](int queue, std::size_t mark) {
    return with_loop(queue, mark) - with_loop(kQueues, mark);
  };
  int index = 0;
  for_each_queue([&]<class Queue>() {
    const int queue = index++;
    if (queue == 0) return;
    const double ours[] = {per_pair(0, 0), per_pair(0, 1)};
    const double theirs[] = {per_pair(queue, 0), per_pair(queue, 1)};
    const char* names[] = {"instructions, push + pop", "instructions, one of a batch of 16"};
    for (int i = 0; i < 2; ++i) {
      Figure figure{"queue",
                    names[i],
                    "",
                    kPairs,
                    spread(ours[i]),
                    Queue::kName,
                    spread(theirs[i]),
                    spread(ours[i] / theirs[i]),
                    {},
                    {}};
      if (i == 0 && queue == 1) set_goal(figure, "<= 34", ours[i] <= 34);
      report.add(figure);
    }
  });
}

}  // namespace sortie::bench
