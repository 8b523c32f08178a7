// SPDX-License-Identifier: BSD-3-Clause
// Reading the latest value while another core writes one every 2 us, against a value behind a mutex.
#include <atomic>
#include <cstdio>
#include <memory>
#include <mutex>

#include "rt/mailbox.hpp"
#include "rt/posix/clock.hpp"
#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

namespace {

template <std::size_t Bytes>
struct Block {
  std::uint64_t words[Bytes / 8]{};
};

template <std::size_t Bytes>
struct Triple {
  void write(const Block<Bytes>& value) { box.write(value); }
  void read(Block<Bytes>& value) { static_cast<void>(box.read(value)); }
  rt::Mailbox<Block<Bytes>> box;
};

template <std::size_t Bytes>
struct Locked {
  void write(const Block<Bytes>& value) {
    const std::lock_guard lock(mutex);
    kept = value;
  }
  void read(Block<Bytes>& value) {
    const std::lock_guard lock(mutex);
    value = kept;
  }
  std::mutex mutex;
  Block<Bytes> kept;
};

constexpr int kPriority = 70;
constexpr rt::Nanoseconds kSlice = 200 * rt::kNanosecondsPerMillisecond;

template <class Box, class Value>
void slice(const Settings& settings, rt::LatencyHistogram& reads) {
  const auto box = std::make_unique<Box>();
  std::atomic<bool> done{false};
  on_both_cores(
      settings, kPriority,
      [&] {
        Value value;
        const rt::Nanoseconds begin = rt::posix::monotonic_now();
        rt::Nanoseconds now = begin;
        for (rt::Nanoseconds next = begin; now - begin < kSlice; next += 1700) {
          while (now < next) now = rt::posix::monotonic_now();
          const rt::Nanoseconds before = rt::posix::monotonic_now();
          box->read(value);
          asm volatile("" : : "r"(&value) : "memory");
          now = rt::posix::monotonic_now();
          reads.record(static_cast<std::uint64_t>(now - before));
        }
        done.store(true);
      },
      [&] {
        Value value;
        for (rt::Nanoseconds next = rt::posix::monotonic_now(); !done.load(std::memory_order_relaxed);
             next += 2000) {
          while (rt::posix::monotonic_now() < next) {
          }
          ++value.words[0];
          box->write(value);
        }
      });
}

template <std::size_t Bytes>
void compare(const Settings& settings, Report& report, const std::string& size, double goal) {
  rt::LatencyHistogram ours;
  rt::LatencyHistogram theirs;
  constexpr double kShares[] = {0.5, 0.99, 0.999};
  Rounds own[3];
  Rounds other[3];
  for (int round = 0; round < settings.rounds; ++round) {
    rt::LatencyHistogram triple;
    rt::LatencyHistogram locked;
    slice<Triple<Bytes>, Block<Bytes>>(settings, triple);
    slice<Locked<Bytes>, Block<Bytes>>(settings, locked);
    for (int i = 0; i < 3; ++i) {
      own[i].add(static_cast<double>(triple.percentile(kShares[i])));
      other[i].add(static_cast<double>(locked.percentile(kShares[i])));
    }
    ours.merge(triple);
    theirs.merge(locked);
  }
  // Of all reads; the range is that of the rounds.
  const auto whole = [](double value, const Rounds& rounds) {
    return Json{{"value", value}, {"low", rounds.low()}, {"high", rounds.high()}};
  };
  const char* names[] = {" read p50", " read p99", " read p99.9"};
  for (int i = 0; i < 3; ++i) {
    const auto mine = static_cast<double>(ours.percentile(kShares[i]));
    const auto peers = static_cast<double>(theirs.percentile(kShares[i]));
    Figure figure{"mailbox",
                  size + names[i],
                  "ns",
                  ours.count(),
                  whole(mine, own[i]),
                  "std::mutex",
                  whole(peers, other[i]),
                  whole(mine / peers, ratio(own[i], other[i])),
                  {},
                  {}};
    if (i == 2) {
      char words[40];
      std::snprintf(words, sizeof words, "ratio <= %.2f", goal);
      set_goal(figure, words, mine <= goal * peers);
    }
    report.add(figure);
  }
}

}  // namespace

void measure_mailboxes(const Settings& settings, Report& report) {
  say("mailboxes");
  if (settings.other_core < 0) {
    report.skip("mailboxes", "this process may use one core only");
    return;
  }
  compare<64>(settings, report, "64 B", 0.25);
  compare<1024>(settings, report, "1 KiB", 0.05);
}

}  // namespace sortie::bench
