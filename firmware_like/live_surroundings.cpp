// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live_surroundings.hpp"

namespace sortie::firmware {

void Surroundings::step_bench(rt::Nanoseconds now) {
  if (bench_ == nullptr) return;
  bench_->step(now);
  truth.note(*bench_, now, &recorder_);
}

void Surroundings::poll_devices(rt::Nanoseconds now) {
  if (link_ != nullptr) link_->poll(now);
  runtime_.vehicle().poll_devices(devices_, now);
}

}  // namespace sortie::firmware
