// SPDX-License-Identifier: BSD-3-Clause
// The noise floor: a thread that does nothing but read the clock, and what is taken from it. What it shows no
// program on this core can be better than.
#include <thread>

#include "rt/histogram.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/fast_clock.hpp"
#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

namespace {

constexpr rt::Nanoseconds kGapNs = 2'000;  // shorter ones belong to the spin itself

struct Noise {
  rt::Nanoseconds spun_ns{};
  rt::Nanoseconds lost_ns{};       // sum of all gaps
  rt::Nanoseconds uncharged_ns{};  // no processor time of this thread: another thread's, or of a stolen core
  rt::LatencyHistogram gaps;
};

void spin_and_watch(rt::Nanoseconds duration_ns, Noise& noise) {
  const rt::Nanoseconds cpu = rt::posix::thread_cpu_now();
  const rt::Nanoseconds start = rt::posix::fast_now();
  rt::Nanoseconds before = start;
  while (before - start < duration_ns) {
    const rt::Nanoseconds now = rt::posix::fast_now();
    if (now - before > kGapNs) {
      noise.gaps.record(static_cast<std::uint64_t>(now - before));
      noise.lost_ns += now - before;
    }
    before = now;
  }
  noise.spun_ns = before - start;
  noise.uncharged_ns = std::max<rt::Nanoseconds>(0, noise.spun_ns - (rt::posix::thread_cpu_now() - cpu));
}

}  // namespace

Json measure_noise(const Settings& settings) {
  Noise noise;
  std::thread([&] {
    const RealtimeSlice slice(settings, settings.core, 70);
    spin_and_watch(static_cast<rt::Nanoseconds>(settings.slice_s * 0.9e9), noise);
  }).join();
  const auto us = [&noise](double share) { return static_cast<double>(noise.gaps.percentile(share)) * 1e-3; };
  const auto percent = [&noise](rt::Nanoseconds part_ns) {
    return 100 * static_cast<double>(part_ns) / static_cast<double>(noise.spun_ns);
  };
  const double spun_s = rt::to_seconds(noise.spun_ns);
  return {{"seconds", spun_s},
          {"gaps_per_s", static_cast<double>(noise.gaps.count()) / spun_s},
          {"p50_us", us(0.5)},
          {"p99_us", us(0.99)},
          {"max_us", us(1.0)},
          {"lost_percent", percent(noise.lost_ns)},
          {"not_charged_percent", percent(noise.uncharged_ns)}};
}

}  // namespace sortie::bench
