// SPDX-License-Identifier: BSD-3-Clause
#include "hil/stop_script.hpp"

#include "drivers/emergency_button.hpp"

namespace sortie::hil {

void StopScript::step(rt::Nanoseconds since_start_ns, drivers::CanBus& port) {
  for (; next_ < deeds_.size() && deeds_[next_].at_ns <= since_start_ns; ++next_) {
    const StopDeed::What what = deeds_[next_].what;
    if (what == StopDeed::What::press || what == StopDeed::What::release) {
      pressed_ = what == StopDeed::What::press;
      next_frame_ns_ = since_start_ns;
    } else {
      powered_ = what == StopDeed::What::power_on;
    }
  }
  if (deeds_.empty() || since_start_ns < next_frame_ns_) return;
  // A frame that a full bus refuses comes again a millisecond later.
  if (port.send(drivers::encode_emergency_button(pressed_, counter_)) != Status::ok) return;
  ++counter_;
  next_frame_ns_ = since_start_ns + kButtonEvery;
}

}  // namespace sortie::hil
