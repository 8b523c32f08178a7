// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/live_surroundings.hpp"

namespace sortie::firmware {

void Surroundings::step_robot(rt::Nanoseconds now) {
  if (robot_ == nullptr) return;
  robot_->step(now);
  truth.note(*robot_, now, &recorder_);
}

void Surroundings::poll_devices(rt::Nanoseconds now) {
  if (link_ != nullptr) link_->poll(now);
  runtime_.vehicle().poll_devices(devices_, now);
}

}  // namespace sortie::firmware
