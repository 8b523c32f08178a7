// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live_surroundings.hpp"

namespace sortie::firmware {

namespace {
constexpr rt::Nanoseconds kTruthEvery = 10 * rt::kNanosecondsPerMillisecond;
}

void Surroundings::step_bench(rt::Nanoseconds now) {
  if (bench_ == nullptr) return;
  bench_->step(now);
  const rt::TruthSample sample = bench_->truth();
  if (sample.flags == 0 || sample.stamp_ns < next_truth_ns_) return;
  next_truth_ns_ = sample.stamp_ns + kTruthEvery;
  truth.add(to_timed_pose(sample));
  std::uint8_t message[drivers::kTruthBytes];
  std::size_t size = 0;
  if (drivers::encode(sample, message, size) == Status::ok) {
    recorder_.sample(std::string(drivers::kChannelTruth), now, {message, size});
  }
}

}  // namespace sortie::firmware
