// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/fly_desk.hpp"

#include "drivers/wire_fly.hpp"

namespace sortie::firmware {

void FlyDesk::take(std::span<const std::uint8_t> message, const drivers::SipKey* key, std::int64_t session,
                   rt::Nanoseconds now_ns, const RequestAge& age) {
  if (!wanted()) return;
  const std::lock_guard lock(mutex_);
  ++judge(message, key, session, now_ns, age);
}

// Returns the counter of what became of the request.
std::uint64_t& FlyDesk::judge(std::span<const std::uint8_t> message, const drivers::SipKey* key,
                              std::int64_t session, rt::Nanoseconds now_ns, const RequestAge& age) {
  drivers::FlyRequestMessage asked;
  const Status form = drivers::decode(message, key, asked);
  if (form != Status::ok) return form == Status::disconnected ? counters_.bad_tag : counters_.malformed;
  if (asked.session != session) return counters_.wrong_session;
  if (!age.fits(asked.utime)) return counters_.wrong_time;
  rt::FlyRequest request;
  request.stamp_ns = now_ns;
  request.counter = asked.counter;
  request.p_world_m[0] = asked.x_m;
  request.p_world_m[1] = asked.y_m;
  request.p_world_m[2] = asked.z_m;
  request.yaw_rad = asked.yaw_rad;
  request.mode = static_cast<std::uint32_t>(asked.mode);
  planner::FlyGate after = gate_;
  Status status = after.take(request);
  if (status == Status::ok) status = port_->push(request, now_ns);
  if (status == Status::ok) gate_ = after;  // a request that did not fit may come again
  switch (status) {
    case Status::ok:
      return counters_.admitted;
    case Status::not_finite:
      return counters_.not_finite;
    case Status::full:
      return counters_.full;
    case Status::time_repeated:
      return counters_.repeated;
    case Status::malformed:
      return counters_.jumped;
    default:
      return counters_.out_of_range;
  }
}

DriveDeskCounters FlyDesk::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

}  // namespace sortie::firmware
