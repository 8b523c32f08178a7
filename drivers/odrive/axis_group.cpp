// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/odrive/axis_group.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace sortie::drivers::odrive {

AxisGroup::AxisGroup(const GroupConfig& config, std::span<const AxisConfig> axes)
    : config_(config), arming_(config.arming) {
  if (axes.empty() || axes.size() > kMaxAxes)
    throw std::runtime_error("odrive: a group has 1 to " + std::to_string(kMaxAxes) + " axes");
  if (config.period_ns < rt::kNanosecondsPerMillisecond)
    throw std::runtime_error("odrive: a cycle takes at least 1 ms");
  axes_.reserve(axes.size());
  for (const AxisConfig& axis : axes) {
    for (const Axis& other : axes_) {
      if (other.config().node == axis.node)
        throw std::runtime_error("odrive: two axes have the number " + std::to_string(axis.node));
    }
    if (axis.silence_ns < 2 * config.period_ns)
      throw std::runtime_error("odrive: a watchdog must outlast two cycles, or it stops an axis that runs");
    axes_.emplace_back(axis);
  }
}

bool AxisGroup::take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  for (Axis& axis : axes_) {
    if (axis.take(frame, now_ns)) return true;
  }
  ++counters_.other_frames;
  return false;
}

void AxisGroup::set(std::span<const double> targets, bool armed, rt::Nanoseconds now_ns) noexcept {
  std::copy_n(targets.begin(), std::min(targets.size(), axes_.size()), targets_.begin());
  arming_.set(armed, now_ns);
}

// The first reason not to run. Before a run an error is no reason: it is forgotten when the run begins, and
// an axis has start_timeout_ns to come up.
StopReason AxisGroup::judge(rt::Nanoseconds now_ns) noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Axis& axis = axes_[i];
    if (axis.phase() != AxisPhase::ready) return running() ? StopReason::drive_lost : StopReason::not_ready;
    if (!running()) continue;
    ran_[i] = ran_[i] || axis.running();
    const bool must_run = ran_[i] || now_ns - arming_.run_ns() > config_.start_timeout_ns;
    if (must_run && !axis.running()) return axis.healthy() ? StopReason::drive_left : StopReason::drive_fault;
  }
  return bus_refused_ ? StopReason::bus_refuses : StopReason::none;
}

void AxisGroup::decide(rt::Nanoseconds now_ns) noexcept {
  const bool healthy = std::all_of(axes_.begin(), axes_.end(), [](const Axis& a) { return a.healthy(); });
  const Arming::Change change = arming_.decide(judge(now_ns), healthy, now_ns);
  if (change == Arming::Change::stopped) ++counters_.stops;
  if (change == Arming::Change::began) ran_.fill(false);
}

void AxisGroup::poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  if (!polled_) next_ns_ = now_ns;
  polled_ = true;
  decide(now_ns);
  if (now_ns < next_ns_) return;
  ++counters_.cycles;
  const rt::Nanoseconds behind = (now_ns - next_ns_) / config_.period_ns;
  counters_.late_cycles += static_cast<std::uint64_t>(behind);
  next_ns_ += (behind + 1) * config_.period_ns;
  bus_refused_ = false;
  for (std::size_t i = 0; i < axes_.size(); ++i) send(axes_[i], targets_[i], now_ns, bus);
}

void AxisGroup::send(Axis& axis, double target, rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  CanFrame frames[kMaxFrames];
  const std::size_t count = axis.cycle(running(), target, now_ns, frames);
  for (std::size_t i = 0; i < count; ++i) {
    if (bus.send(frames[i]) == Status::ok) continue;
    ++counters_.send_refused;
    bus_refused_ = true;
    return;  // the step comes again
  }
  if (count > 0) axis.sent(now_ns);
}

}  // namespace sortie::drivers::odrive
