// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/odrive/axis_line.hpp"

#include <stdexcept>
#include <string>

#include "drivers/drive_group.hpp"

namespace sortie::drivers::odrive {
AxisLine::AxisLine(rt::Nanoseconds period_ns, std::span<const AxisConfig> axes) : period_ns_(period_ns) {
  if (axes.empty() || axes.size() > kMaxDrives)
    throw std::runtime_error("odrive: a line has 1 to " + std::to_string(kMaxDrives) + " axes");
  if (period_ns < 3 * rt::kNanosecondsPerMillisecond)
    throw std::runtime_error("odrive: a cycle takes at least 3 ms");
  axes_.reserve(axes.size());
  for (const AxisConfig& axis : axes) {
    for (const Axis& other : axes_) {
      if (other.config().node == axis.node)
        throw std::runtime_error("odrive: two axes have the number " + std::to_string(axis.node));
    }
    if (axis.silence_ns < 2 * period_ns)
      throw std::runtime_error("odrive: a watchdog must outlast two cycles, or it stops an axis that runs");
    axes_.emplace_back(axis);
  }
  next_ = axes_.size();
}

bool AxisLine::take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  for (Axis& axis : axes_) {
    if (axis.take(frame, now_ns)) return true;
  }
  ++counters_.other_frames;
  return false;
}

bool AxisLine::works(rt::Nanoseconds now_ns) const noexcept {
  return now_ns - whole_ns_ <= deaf_after(period_ns_);
}

void AxisLine::watch(bool torque, rt::Nanoseconds now_ns) noexcept {
  if (!polled_) next_ns_ = whole_ns_ = now_ns;
  polled_ = true;
  for (Axis& axis : axes_) axis.watch(torque, now_ns);
}

void AxisLine::send(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  if (now_ns >= next_ns_) {
    ++counters_.cycles;
    const rt::Nanoseconds behind = (now_ns - next_ns_) / period_ns_;
    counters_.late_cycles += static_cast<std::uint64_t>(behind);
    next_ns_ += (behind + 1) * period_ns_;
    if (next_ == axes_.size()) next_ = 0;  // else the cycle before is not out yet, and goes on
  }
  int frames = 0;
  while (next_ < axes_.size() && frames < kBurst) {
    if (!send_to(axes_[next_], now_ns, bus, frames)) return;
    if (++next_ == axes_.size()) whole_ns_ = now_ns;
  }
}

bool AxisLine::send_to(Axis& axis, rt::Nanoseconds now_ns, CanBus& bus, int& frames) noexcept {
  CanFrame out[kMaxFrames];
  const std::size_t count = axis.cycle(now_ns, out);
  for (std::size_t i = 0; i < count; ++i) {
    if (bus.send(out[i]) != Status::ok) {
      ++counters_.send_refused;
      return false;  // the step comes again
    }
    ++frames;
  }
  if (count > 0) axis.sent(now_ns);
  return true;
}

}  // namespace sortie::drivers::odrive
