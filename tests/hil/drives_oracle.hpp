// SPDX-License-Identifier: BSD-3-Clause
// The promise of docs/safety.md, told without the group that keeps it: no motor is driven unless all drives
// run, a fresh command of its own source asks for it, and no stop is pending. It looks at the world alone: at
// what was said, what was done to it, and what the simulated drives do; it asks nothing of what it judges.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tests/hil/drives_world.hpp"

namespace sortie::hil::test {

/// How soon each cause must have ended what it ends, ms. docs/safety.md states them ("From a cause to the
/// order"), and tests/hil/drives_docs_test.cpp compares.
struct StopBounds {
  int command = 25;  ///< a command that ends, an emergency stop, a fault once it is told: frames on their way
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

  /// `rearm_ns`: as the group has it; 0: never.
  explicit DrivesOracle(rt::Nanoseconds rearm_ns = 0) : rearm_ns_(rearm_ns) {}

  // Tell it what is done to the world.
  void note_press(bool pressed) { pressed_ = pressed; }
  /// The first drive fails. Where only a frame tells of it (ODrive), it counts from that frame on.
  void note_fault(bool had_torque, rt::Nanoseconds now_ns) {
    if (!Kind::kTold) fault_ns_ = now_ns;
    untold_ = Kind::kTold;
    had_torque_ = had_torque;
    failed_ns_ = now_ns;
  }
  /// A drive has lost its power: it is not what it was before, however short that was.
  void note_loss(rt::Nanoseconds now_ns) { lose(now_ns); }
  void set_broken(bool broken) { broken_ = broken; }  ///< somebody cannot hear or be heard, or does not run

  /// After each millisecond. Empty, or what is against the promise.
  std::string look(DrivesWorld<Kind>& world) {
    const rt::Nanoseconds now = world.now();
    const bool heard = world.lives_ && !world.starved_;
    sources_[0].hear(heard && world.drive_speaks_, world.drive_.flags, world.drive_.asked, now);
    sources_[1].hear(heard && world.flippers_speak_, world.flipper_.flags, world.flipper_.asked, now);
    // When the one that has not run for the longest time ran last. Not when all ran at one moment: what a
    // drive says of itself is as old as its heartbeat, and no program could know better.
    all_ran_ns_ = now;
    bool all = true;
    for (std::size_t i = 0; i < world.size(); ++i) {
      if (world.runs(i)) ran_ns_[i] = now;
      all = all && world.runs(i) && Kind::fed_since(world.node(i), now - 15 * kMs);
      all_ran_ns_ = std::min(all_ran_ns_, ran_ns_[i]);
    }
    note_runs(all, now);
    if (untold_ && world.fault_told_ns() == now) {
      if (!had_torque_ || Kind::fed_since(world.node(0), failed_ns_)) fault_ns_ = now;
      untold_ = false;
    }
    untold_ = untold_ && Kind::has_fault(world.node(0));
    if (!broken_) whole_ns_ = now;
    if (broken_) broken_ns_ = now;
    // So long that whoever watches must have stopped.
    if (now - whole_ns_ > (world.starved_ ? kSurelyStarved : bounds_.loss) * kMs) lose(now);
    if (!pressed_) free_ns_ = now;
    if (pressed_) pressed_ns_ = now;
    for (std::size_t s = 0; s < (world.size() > 2 ? 2 : 1); ++s) {
      if (sources_[s].on && now - sources_[s].spoken_ns > 200 * kMs) silent_ns_ = now;
    }
    // Broken so recently that somebody may still not know.
    const bool torn = now - broken_ns_ <= bounds_.loss * kMs;
    const int told = torn ? bounds_.loss : bounds_.command;
    for (std::size_t i = 0; i < world.size(); ++i) {
      if (!world.driven(i)) continue;
      const Source& source = sources_[i < 2 ? 0 : 1];
      const std::string who = (i < 2 ? "wheel " : "flipper ") + std::to_string(i) + " is driven at " +
                              std::to_string(now / kMs) + " ms: ";
      if (now - all_ran_ns_ > (torn ? bounds_.loss : bounds_.fault) * kMs) return who + "not all drives run";
      if (now - free_ns_ > told * kMs) return who + "an emergency stop is pressed";
      // Who could not be told after a silence did not know of it before its time-out either.
      if (now - source.asked_ns > (torn ? bounds_.loss + bounds_.silence : bounds_.silence) * kMs)
        return who + "nobody asks for it";
      if (!source.on && now - source.asked_ns > told * kMs) return who + "its source said off";
      if (now - whole_ns_ > bounds_.loss * kMs) return who + "a drive is out of reach";
      if (stop_pending(source, now, torn)) return who + "it was not asked anew";
    }
    if (now - free_ns_ > bounds_.no_torque * kMs && now - broken_ns_ > bounds_.no_torque * kMs &&
        world.torque())
      return "torque at " + std::to_string(now / kMs) + " ms while an emergency stop is pressed";
    return {};
  }

  /// For a search: what the judge will say of what is to come.
  std::uint64_t likeness(rt::Nanoseconds now) const {
    std::uint64_t h = 0;
    const auto age = [&](rt::Nanoseconds at) {
      h = h * 31 + static_cast<std::uint64_t>(std::min<rt::Nanoseconds>((now - at) / (40 * kMs), 12));
    };
    for (const rt::Nanoseconds at : {all_ran_ns_, whole_ns_, free_ns_, broken_ns_}) age(at);
    for (const Source& source : sources_) {
      age(source.asked_ns);
      age(source.spoken_ns);
      for (const rt::Nanoseconds at : {pressed_ns_, fault_ns_, silent_ns_, source.lost_ns})
        h = h * 2 + (source.edge_ns <= at ? 1u : 0u);
      h = h * 8 + (source.on ? 1u : 0u) + (source.ran ? 2u : 0u) + (source.stopped ? 4u : 0u);
    }
    return h * 8 + (untold_ ? 1u : 0u) + (broken_ ? 2u : 0u) + (pressed_ ? 4u : 0u);
  }

 private:
  static constexpr rt::Nanoseconds kLong = 1'000'000 * kMs;
  static constexpr int kSurelyStarved = 165;  // longer than any drive waits for us

  /// What was heard of one source: a request is a number that has risen, while it is on.
  struct Source {
    bool on{true};
    std::uint32_t number{};
    rt::Nanoseconds edge_ns{-kLong}, asked_ns{-kLong}, spoken_ns{-kLong}, lost_ns{-kLong};
    bool stopped{}, ran{};  // since the edge: not all ran; all did, as that request made them
    void hear(bool speaks, std::uint32_t flags, std::uint32_t asked, rt::Nanoseconds now) {
      if (!speaks) return;
      const bool says = flags != 0;
      // What was asked in a silence was asked before its end was known.
      if (says && asked > number && (spoken_ns == -kLong || now - spoken_ns <= 200 * kMs)) {
        edge_ns = now;
        stopped = ran = false;
      }
      on = says;
      number = asked;
      if (says) asked_ns = now;
      spoken_ns = now;
    }
  };

  // A request waits for drives that are set up, however often one is lost on the way; what has run since it
  // was asked for, and is lost, is over.
  void lose(rt::Nanoseconds now) {
    for (Source& source : sources_) {
      if (source.ran) source.lost_ns = now;
    }
  }
  // Axes that are put under torque for their proof (ODrive) are let go within a heartbeat: that is no run.
  void note_runs(bool all, rt::Nanoseconds now) {
    if (!all) apart_ns_ = now;
    all = all && (!Kind::kTold || now - apart_ns_ > 65 * kMs);
    for (Source& source : sources_) {
      source.stopped = source.stopped || apart_ns_ == now;
      // A stop that was going on when it was asked is no run of its own.
      source.ran = source.ran || (all && (source.stopped || now - source.edge_ns > 300 * kMs));
    }
  }

  // Each cause ends what was asked for before it, of its own source and of every other. Where drives re-arm
  // by themselves they must have been there for that long. A silence is no illness of theirs, nor is a fault
  // that a start forgets: what re-arms may forget it at once.
  bool stop_pending(const Source& source, rt::Nanoseconds now, bool torn) const {
    const auto pending = [&](rt::Nanoseconds cause_ns, int bound, rt::Nanoseconds rearms_after) {
      const bool over = rearm_ns_ > 0 && now - cause_ns >= rearms_after;
      return source.edge_ns <= cause_ns && now - cause_ns > bound * kMs && !over;
    };
    const int told = torn ? bounds_.loss : bounds_.command;
    return pending(pressed_ns_, told, kLong) || pending(fault_ns_, told, 0) || pending(silent_ns_, told, 0) ||
           pending(source.lost_ns, bounds_.loss, rearm_ns_);
  }

  StopBounds bounds_{};
  rt::Nanoseconds rearm_ns_;
  std::array<Source, 2> sources_{};  // tracks, flippers
  bool broken_{}, pressed_{}, untold_{};
  std::array<rt::Nanoseconds, 6> ran_ns_{-kLong, -kLong, -kLong, -kLong, -kLong, -kLong};
  rt::Nanoseconds all_ran_ns_{-kLong}, whole_ns_{}, free_ns_{};
  rt::Nanoseconds broken_ns_{-kLong}, pressed_ns_{-kLong}, fault_ns_{-kLong}, silent_ns_{-kLong},
      failed_ns_{-kLong};
  rt::Nanoseconds apart_ns_{};
  bool had_torque_{};
};

}  // namespace sortie::hil::test
