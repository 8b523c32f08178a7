// SPDX-License-Identifier: BSD-3-Clause
// The noise floor: a thread that does nothing but read the clock, and what is taken from it.
#include <thread>

#include "rt/posix/spin_detector.hpp"
#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

Json measure_noise(const Settings& settings) {
  rt::posix::SpinNoise noise;
  std::thread([&] {
    const RealtimeSlice slice(settings, settings.core, 70);
    rt::posix::spin_and_watch(static_cast<rt::Nanoseconds>(settings.slice_s * 0.9e9), noise);
  }).join();
  const auto us = [&noise](double share) { return static_cast<double>(noise.gaps.percentile(share)) * 1e-3; };
  return {{"seconds", rt::to_seconds(noise.spun_ns)},
          {"gaps_per_s", noise.rate_hz()},
          {"p50_us", us(0.5)},
          {"p99_us", us(0.99)},
          {"max_us", us(1.0)},
          {"lost_percent", 100 * noise.lost_share()},
          {"not_charged_percent",
           100 * static_cast<double>(noise.uncharged_ns) / static_cast<double>(noise.spun_ns)}};
}

}  // namespace sortie::bench
