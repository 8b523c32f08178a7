// SPDX-License-Identifier: BSD-3-Clause
// The promise of docs/safety.md, told without the group that keeps it: no wheel is driven unless all drives
// run, a fresh command of its own source asks for it, and no stop is pending. It looks at the world alone:
// at what was said, what was broken, and what the simulated drives do.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tests/hil/drives_world.hpp"

namespace sortie::hil::test {

/// How soon each cause must have ended what it ends, ms. The bounds that docs/safety.md states.
struct StopBounds {
  int command = 25;      ///< a command that ends, an emergency stop: a cycle, frames on their way
  int silence = 225;     ///< of a source: its time-out, and a cycle
  int fault = 90;        ///< told by a frame, or by the next heartbeat
  int loss = 280;        ///< nobody tells: a time-out of heartbeats or a watchdog, and their age
  int no_torque = 1200;  ///< from an emergency stop until no drive has torque, the bus being whole
};

/// Judges a world, millisecond by millisecond.
template <class Kind>
class DrivesOracle {
 public:
  static constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;

  /// Tell it what is done to the world.
  void note_fault(rt::Nanoseconds now_ns) { fault_ns_ = now_ns; }
  void set_broken(bool broken) { broken_ = broken; }  ///< somebody cannot hear or be heard, or does not run

  /// After each millisecond. Empty, or what is against the promise.
  std::string look(const DrivesWorld<Kind>& world, bool rearms) {
    const rt::Nanoseconds now = world.now();
    const bool pressed = world.runtime().pressed();
    const bool on = (world.drive_.flags & 1u) != 0;
    if (world.lives_ && !world.starved_ && world.drive_speaks_) {
      if (on && !on_) edge_ns_ = now;
      on_ = on;
      if (on) asked_ns_ = now;
      if (on) spoken_ns_ = now;
      if (!on) spoken_ns_ = -kLong;
    }
    all_ran_ns_ = now;  // when the one that has not run for the longest time ran last
    for (std::size_t i = 0; i < world.size(); ++i) {
      if (world.runs(i)) ran_ns_[i] = now;
      all_ran_ns_ = std::min(all_ran_ns_, ran_ns_[i]);
    }
    if (!broken_) whole_ns_ = now;
    if (!pressed) free_ns_ = now;
    if (pressed) pressed_ns_ = now;
    if (broken_) broken_ns_ = now;
    if (on_ && now - spoken_ns_ > 200 * kMs) silent_ns_ = now;
    // Broken so recently that somebody may still not know.
    const bool torn = now - broken_ns_ <= bounds_.loss * kMs;
    const int told = torn ? bounds_.loss : bounds_.command;
    for (std::size_t i = 0; i < 2; ++i) {
      if (!world.driven(i)) continue;
      const std::string who =
          "wheel " + std::to_string(i) + " is driven at " + std::to_string(now / kMs) + " ms: ";
      if (now - all_ran_ns_ > (torn ? bounds_.loss : bounds_.fault) * kMs) return who + "not all drives run";
      if (now - free_ns_ > told * kMs) return who + "an emergency stop is pressed";
      // Who could not be told after a silence did not know of it before its time-out either.
      if (now - asked_ns_ > (torn ? bounds_.loss + bounds_.silence : bounds_.silence) * kMs)
        return who + "nobody asks for it";
      if (!on_ && now - asked_ns_ > told * kMs) return who + "its source said off";
      if (now - whole_ns_ > bounds_.loss * kMs) return who + "a drive is out of reach";
      if (stop_pending(now, rearms)) return who + "it was not asked anew";
    }
    if (now - free_ns_ > bounds_.no_torque * kMs && now - broken_ns_ > bounds_.no_torque * kMs &&
        world.torque())
      return "torque at " + std::to_string(now / kMs) + " ms while an emergency stop is pressed";
    return {};
  }

  /// For a search: what the judge will say of what is to come.
  std::uint64_t likeness(rt::Nanoseconds now) const {
    std::uint64_t h = 0;
    for (const rt::Nanoseconds at : {asked_ns_, spoken_ns_, all_ran_ns_, whole_ns_, free_ns_, broken_ns_})
      h = h * 31 + static_cast<std::uint64_t>(std::min<rt::Nanoseconds>((now - at) / (40 * kMs), 12));
    for (const rt::Nanoseconds at : {pressed_ns_, fault_ns_, silent_ns_})
      h = h * 2 + (edge_ns_ <= at ? 1u : 0u);
    return h * 4 + (on_ ? 1u : 0u) + (broken_ ? 2u : 0u);
  }

 private:
  static constexpr rt::Nanoseconds kLong = 1'000'000 * kMs;
  // Each cause ends what was asked for before it.
  bool stop_pending(rt::Nanoseconds now, bool rearms) const {
    const auto pending = [&](rt::Nanoseconds cause_ns, int bound) {
      return edge_ns_ <= cause_ns && now - cause_ns > bound * kMs;
    };
    const bool torn = now - broken_ns_ <= bounds_.loss * kMs;
    if (pending(pressed_ns_, torn ? bounds_.loss : bounds_.command)) return true;
    if (rearms) return false;
    return pending(fault_ns_, torn ? bounds_.loss : bounds_.fault) ||
           pending(silent_ns_, torn ? bounds_.loss : bounds_.command);
  }

  StopBounds bounds_{};
  bool on_{true};
  bool broken_{};
  rt::Nanoseconds edge_ns_{-kLong}, asked_ns_{-kLong}, spoken_ns_{-kLong}, all_ran_ns_{-kLong};
  std::array<rt::Nanoseconds, 6> ran_ns_{-kLong, -kLong, -kLong, -kLong, -kLong, -kLong};
  rt::Nanoseconds whole_ns_{}, free_ns_{};
  rt::Nanoseconds broken_ns_{-kLong}, pressed_ns_{-kLong}, fault_ns_{-kLong}, silent_ns_{-kLong};
};

}  // namespace sortie::hil::test
