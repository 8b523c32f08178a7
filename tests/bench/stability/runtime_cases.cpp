// SPDX-License-Identifier: BSD-3-Clause
// Stamps, counters and numbers at their ends.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "drivers/can_unwrap.hpp"
#include "drivers/lcm_receiver.hpp"
#include "rt/histogram.hpp"
#include "rt/let_channel.hpp"
#include "rt/math.hpp"
#include "rt/saturating_count.hpp"
#include "rt/spsc_ring.hpp"
#include "rt/stamp_gate.hpp"
#include "tests/bench/stability/cases.hpp"

namespace sortie::bench {

namespace {

constexpr rt::Nanoseconds kSecond = rt::kNanosecondsPerSecond;

// Takes what is newer than all before.
struct NewestGate {
  rt::Nanoseconds last{std::numeric_limits<rt::Nanoseconds>::min()};
  Status take(rt::Nanoseconds stamp) {
    if (stamp <= last) return Status::time_backwards;
    last = stamp;
    return Status::ok;
  }
};

// Compares positions as plain numbers.
struct PlainRing {
  std::uint32_t written;
  std::uint32_t read;
  bool push() {
    if (written >= read + 8u) return false;
    ++written;
    return true;
  }
  bool pop() {
    if (read >= written) return false;
    ++read;
    return true;
  }
};

template <class Gate>
double refused_of_a_thousand(Gate gate, rt::Nanoseconds wild, rt::Nanoseconds from) {
  static_cast<void>(gate.take(0));
  static_cast<void>(gate.take(wild));
  int refused = 0;
  for (int i = 1; i <= 1000; ++i) refused += gate.take(from + i * kSecond / 100) == Status::ok ? 0 : 1;
  return refused;
}

}  // namespace

StabilityFigures wrapped_ring() {
  constexpr std::uint32_t kFirst = 0xfffffffau;
  constexpr int kElements = 20;
  rt::SpscRing<int, 8> ring(kFirst);
  PlainRing plain{kFirst, kFirst};
  int lost = 0;
  int plainly_lost = 0;
  for (int i = 0; i < kElements; ++i) {
    int got = -1;
    if (!ring.try_push(i) || !ring.try_pop(got) || got != i) ++lost;
    if (!plain.push() || !plain.pop()) ++plainly_lost;
  }
  return {static_cast<double>(lost), static_cast<double>(plainly_lost)};
}

StabilityFigures wild_stamp() {
  constexpr rt::Nanoseconds kYear = 31'557'600 * kSecond;
  return {refused_of_a_thousand(rt::StampGate(10 * kSecond), kYear, 0),
          refused_of_a_thousand(NewestGate{}, kYear, 0)};
}

StabilityFigures clock_set_back() {
  constexpr rt::Nanoseconds kHour = 3600 * kSecond;
  return {refused_of_a_thousand(rt::StampGate(10 * kSecond), kSecond, -kHour),
          refused_of_a_thousand(NewestGate{}, kSecond, -kHour)};
}

StabilityFigures extreme_stamps() {
  constexpr rt::Nanoseconds kLow = std::numeric_limits<rt::Nanoseconds>::min();
  constexpr rt::Nanoseconds kHigh = std::numeric_limits<rt::Nanoseconds>::max();
  rt::StampGate gate(10 * kSecond);
  static_cast<void>(gate.take(0));
  int taken = 0;
  int naively_taken = 0;
  rt::Nanoseconds last = kHigh - 1;
  for (const rt::Nanoseconds stamp : {kLow, kHigh, kLow + 5, kHigh - 7}) {
    taken += gate.take(stamp) == Status::ok ? 1 : 0;
    // The difference as hardware makes it: it wraps.
    const auto step =
        static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(stamp) - static_cast<std::uint64_t>(last));
    if (step <= 0 || step > 10 * kSecond) continue;
    last = stamp;
    ++naively_taken;
  }
  return {static_cast<double>(taken), static_cast<double>(naively_taken)};
}

StabilityFigures full_counter() {
  rt::SaturatingCount count;
  count.set(rt::SaturatingCount::kTop - 1);
  std::uint32_t plain = rt::SaturatingCount::kTop - 1;
  for (int i = 0; i < 4; ++i) {
    count.add();
    ++plain;
  }
  constexpr double kTop = rt::SaturatingCount::kTop;
  return {kTop - count.value(), kTop - plain};
}

StabilityFigures rank_of_share() {
  rt::LatencyHistogram histogram;
  for (std::uint64_t ns = 1; ns <= 50; ++ns) histogram.record_many(ns, 2);
  // Share k / 100 of 100 durations is the k-th one, (k + 1) / 2 ns.
  int wrong = 0;
  int naively_wrong = 0;
  for (std::uint64_t k = 1; k <= 100; ++k) {
    const double share = static_cast<double>(k) * 0.01;
    const double rank = std::ceil(share * 100.0);
    wrong += histogram.percentile(share) == (k + 1) / 2 ? 0 : 1;
    naively_wrong += static_cast<std::uint64_t>(rank) == k ? 0 : 1;
  }
  return {static_cast<double>(wrong), static_cast<double>(naively_wrong)};
}

StabilityFigures denormal_length() {
  constexpr double kUnit = 5e-324;
  const double x = 3e4 * kUnit;
  const double y = 4e4 * kUnit;
  const double truth = 5e4 * kUnit;
  return {std::fabs(rt::hypot(x, y) / truth - 1), std::fabs(std::sqrt(x * x + y * y) / truth - 1)};
}

StabilityFigures long_length() {
  const double x = 0x3p800;
  const double y = 0x4p800;
  const double truth = 0x5p800;
  return {std::fabs(rt::hypot(x, y) / truth - 1), std::fabs(std::sqrt(x * x + y * y) / truth - 1)};
}

StabilityFigures short_device_time() {
  // A device that speaks every 100 ms for 20 s; its counter wraps three times.
  constexpr rt::Nanoseconds kStep = kSecond / 10;
  const drivers::CanCounterClock clock(0, kSecond, kSecond / 1000);
  StabilityFigures worst{0, 0};
  rt::Nanoseconds naive = 0;
  std::uint16_t before = 0;
  for (rt::Nanoseconds truth = kStep; truth <= 20 * kSecond; truth += kStep) {
    const std::uint16_t counter = clock.counter(truth);
    rt::Nanoseconds stamp = 0;
    const Status status = clock.unwrap(counter, truth + kSecond / 5000, stamp);
    keep_worst(worst.ours, status == Status::ok ? std::fabs(rt::to_seconds(stamp - truth)) : std::nan(""));
    naive += (std::int64_t{counter} - before) * drivers::kCanCounterStepNs;
    before = counter;
    keep_worst(worst.naive, std::fabs(rt::to_seconds(naive - truth)));
  }
  return worst;
}

StabilityFigures late_releases() {
  // A group of 100 Hz whose every wake-up comes 0.3 ms late, for ten minutes.
  constexpr rt::Nanoseconds kTick = kSecond / 1000;
  constexpr rt::Nanoseconds kLate = kSecond / 1000 * 3 / 10;
  const rt::GroupTiming timing{10, 0, 10};
  rt::Nanoseconds ours = 0;
  rt::Nanoseconds naive = 0;
  constexpr std::uint64_t kJobs = 60000;
  for (std::uint64_t job = 1; job <= kJobs; ++job) {
    ours = static_cast<rt::Nanoseconds>(timing.release(job)) * kTick;
    naive = naive + kLate + 10 * kTick;  // a period from when it woke
  }
  const double truth = 0.01 * static_cast<double>(kJobs);
  return {std::fabs(rt::to_seconds(ours) - truth), std::fabs(rt::to_seconds(naive) - truth)};
}

StabilityFigures wrapping_fragment() {
  // "LC03", sequence, size of the message, offset of this piece, its number, how many: the piece ends where
  // it starts.
  constexpr std::uint32_t kOffset = 0xfffffff0U;
  constexpr std::uint32_t kMessage = 100;
  std::uint8_t datagram[20 + 6 + 32]{'L',  'C',  '0',  '3', 0, 0, 0, 1,   0,   0,   0,   kMessage, 0xff,
                                     0xff, 0xff, 0xf0, 0,   0, 0, 2, 'P', 'O', 'S', 'E', 0};
  drivers::Lc02Message message;
  const Status status = drivers::parse_lc02(datagram, message);
  // A receiver that puts fragments together writes the piece where offset + size does not exceed the message,
  // in 32 bits.
  const std::uint32_t piece = 32;
  const bool fits = kOffset + piece <= kMessage;
  const double written = fits ? static_cast<double>(kOffset) + piece - kMessage : 0.0;
  return {status == Status::not_supported ? 0.0 : 1.0, written};
}

StabilityFigures sine_of_large() {
  constexpr double kAngle = 1e22;
  constexpr double kTruth = -0.8522008497671888;  // of the double 1e22, exact to the last digit
  const double reduced = std::fmod(kAngle, 6.283185307179586);
  return {std::fabs(rt::sin(kAngle) - kTruth), std::fabs(rt::sin(reduced) - kTruth)};
}

}  // namespace sortie::bench
