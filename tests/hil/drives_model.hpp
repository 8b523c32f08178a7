// SPDX-License-Identifier: BSD-3-Clause
// Every order in which a short list of things can happen to the robot's drives, to a depth, judged by
// tests/hil/drives_oracle.hpp.
#pragma once

#include <string>
#include <unordered_set>
#include <vector>

#include "tests/hil/drives_oracle.hpp"

namespace sortie::hil::test {

/// What can happen next. Those that last are switched on, and off again when they come up once more.
enum class Deed : std::uint8_t {
  request,  ///< the operator says off, and then on, for the tracks
  silence,  ///< the tracks' source falls silent, or speaks again
  loss,     ///< a drive loses its power, or gets it
  mute,     ///< a drive is not read any more, or is
  fault,    ///< a drive has a fault
  bus_off,  ///< our controller leaves the bus, or is back
  press,    ///< the emergency stop is pressed, or released
  starve,   ///< the process does not run for longer than the drives wait
  // Where there are flippers.
  flippers_request,
  flippers_silence,
};
inline constexpr int kDeeds = 8;
inline constexpr int kDeedsWithFlippers = 10;

/// A world, its judge, and what was done.
template <class Kind>
struct DrivesModel {
  DrivesWorld<Kind> world;
  DrivesOracle<Kind> oracle;
  bool unpowered{};
  bool muted{};
  bool pressed{};
  std::string found{};  ///< what the judge said first

  void pass(int ms) {
    for (int i = 0; i < ms && found.empty(); ++i) {
      world.step();
      oracle.set_broken(unpowered || muted || world.bus_off() || world.starved_);
      found = oracle.look(world);
    }
  }
  void act(Deed deed) {
    const bool had_torque = Kind::torque(world.node(0));
    switch (deed) {
      case Deed::request:
        world.ask_drive(false);
        pass(12);
        world.ask_drive(true);
        break;
      case Deed::flippers_request:
        world.ask_flippers(false);
        pass(12);
        world.ask_flippers(true);
        break;
      case Deed::flippers_silence:
        world.flippers_speak_ = !world.flippers_speak_;
        break;
      case Deed::silence:
        world.drive_speaks_ = !world.drive_speaks_;
        break;
      case Deed::loss:
        unpowered = !unpowered;
        world.node(1).set_power(!unpowered);
        if (unpowered) oracle.note_loss(world.now());
        break;
      case Deed::mute:
        muted = !muted;
        Kind::mute(world.node(1), muted);
        break;
      case Deed::fault:
        // A fault on top of a fault is forgotten with it, and a drive that has not booted has none.
        if (Kind::has_fault(world.node(0))) break;
        Kind::fault(world.node(0));
        if (Kind::has_fault(world.node(0)) && !world.fault_shown())
          oracle.note_fault(had_torque, world.now());
        break;
      case Deed::bus_off:
        world.set_bus_off(!world.bus_off());
        break;
      case Deed::press:
        pressed = !pressed;
        world.runtime().press(pressed);
        oracle.note_press(pressed);
        break;
      case Deed::starve:
        world.starved_ = true;
        pass(170);
        world.starved_ = false;
        break;
    }
  }

  int deeds() const { return world.size() > 2 ? kDeedsWithFlippers : kDeeds; }

  /// What is alike here is alike from here on, but for tens of milliseconds.
  std::uint64_t likeness() {
    std::uint64_t h = 1469598103934665603ull;
    const auto add = [&h](std::uint64_t value) { h = (h ^ value) * 1099511628211ull; };
    const auto& group = world.runtime().group();
    add(static_cast<std::uint64_t>(group.state()));
    add(static_cast<std::uint64_t>(group.reason()));
    add(unpowered | muted << 1 | world.bus_off() << 2 | pressed << 3 | world.drive_speaks_ << 4 |
        world.flippers_speak_ << 5);
    add(static_cast<std::uint64_t>(group.age_ns(world.now()) / (40 * DrivesWorld<Kind>::kMs)) & 63u);
    for (std::size_t i = 0; i < world.size(); ++i) {
      add(static_cast<std::uint64_t>(world.node(i).state()));
      add(static_cast<std::uint64_t>(world.node(i).command().on));
      add(static_cast<std::uint64_t>(std::lround(20.0 * world.speed(i)) + 100));
    }
    if constexpr (requires { world.runtime().line().cut(); }) {
      add(world.runtime().line().cut());
      for (std::size_t i = 0; i < world.size(); ++i) {
        add(static_cast<std::uint64_t>(world.runtime().line().drive(i).phase()));
        add(static_cast<std::uint64_t>(world.node(i).nmt()));
      }
    } else {
      for (std::size_t i = 0; i < world.size(); ++i) {
        add(static_cast<std::uint64_t>(world.runtime().line().axis(i).phase()));
        add(world.node(i).error());
      }
    }
    add(world.fault_shown());
    add(oracle.likeness(world.now()));
    return h;
  }
};

/// A model whose drives have been asked for, with or without success.
template <class Kind>
DrivesModel<Kind> asked_model(bool flippers, rt::Nanoseconds rearm_ns, int set_up_ms = 3000) {
  typename Kind::Config config;
  config.group.rearm_ns = rearm_ns;
  DrivesModel<Kind> model{DrivesWorld<Kind>(flippers, config), DrivesOracle<Kind>(rearm_ns)};
  model.world.swing_rad_ = flippers ? 0.5 : 0.0;
  model.world.ask(false);
  model.pass(set_up_ms);
  model.world.ask(true);
  return model;
}

/// How a search went.
struct SearchResult {
  std::uint64_t states{};   ///< that were gone on from
  std::uint64_t alike{};    ///< that were like one before, at no greater depth
  std::uint64_t running{};  ///< in which all drives ran
  std::string found;        ///< empty, or the first offence
  std::vector<int> way;     ///< to it
};

/// Depth first, every deed after every deed, `dwell_ms` apart. With `merges`, what is alike is gone on from
/// once at each depth.
template <class Kind>
class DrivesSearch {
 public:
  DrivesSearch(int depth, int dwell_ms, bool merges)
      : dwell_ms_(dwell_ms), merges_(merges), seen_(static_cast<std::size_t>(depth) + 1) {}
  SearchResult operator()(const DrivesModel<Kind>& from) {
    go(from, static_cast<int>(seen_.size()) - 1);
    return result_;
  }

 private:
  void go(const DrivesModel<Kind>& from, int depth) {
    ++result_.states;
    if (from.world.runtime().running()) ++result_.running;
    for (int deed = 0; deed < from.deeds() && depth > 0 && result_.found.empty(); ++deed) {
      DrivesModel<Kind> next(from);
      way_.push_back(deed);
      next.act(static_cast<Deed>(deed));
      next.pass(dwell_ms_);
      if (!next.found.empty()) {
        result_.found = next.found;
        result_.way = way_;
      } else if (merges_ && !seen_[static_cast<std::size_t>(depth - 1)].insert(next.likeness()).second) {
        ++result_.alike;
      } else {
        go(next, depth - 1);
      }
      way_.pop_back();
    }
  }

  int dwell_ms_;
  bool merges_;
  std::vector<std::unordered_set<std::uint64_t>> seen_;
  std::vector<int> way_;
  SearchResult result_;
};

}  // namespace sortie::hil::test
