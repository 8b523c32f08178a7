// SPDX-License-Identifier: BSD-3-Clause
// Replays that keep their states, and a log that is indexed.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "firmware_like/log/keyframe_state.hpp"
#include "firmware_like/log/keyframes.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {

/// A replay and the states that it went through.
struct Indexed {
  firmware::ReplayOutcome outcome;
  std::map<rt::Tick, std::vector<std::uint8_t>> states;
};

/// Replays and keeps the state at every `every`-th tick; writes a file of keyframes if `path` is given.
inline Indexed replay_and_keep(const std::string& log_path, const firmware::VehicleRegistry& vehicles,
                               firmware::ReplayOptions options, rt::Tick every,
                               const std::string& path = "") {
  const firmware::LogFile log(log_path);
  Indexed result;
  firmware::KeyframeHead head;
  options.on_tick = [&](rt::Tick tick, firmware::Runtime& runtime, firmware::LogFeed& feed) {
    head = firmware::keyframe_head(log, runtime);
    if (tick % every == 0) result.states[tick] = firmware::save_state(runtime, feed, tick);
  };
  result.outcome = firmware::replay(log, vehicles, options);
  if (path.empty()) return result;
  firmware::KeyframeWriter writer(path, head);
  for (const auto& [tick, state] : result.states) {
    if (tick > 0) writer.add(tick, state);
  }
  writer.finish();
  return result;
}

/// Two seconds of ugv_hall, indexed every 25 ms, made once.
struct IndexedHall : RecordedHall {
  IndexedHall() : RecordedHall(2) {}
  Indexed full = replay_and_keep(log, firmware::own_vehicles(), {}, 25, firmware::keyframe_path(log));
};
inline const IndexedHall& hall() {
  static const IndexedHall recorded;
  return recorded;
}

/// Why a replay of the hall's log is refused; empty when it is not.
inline std::string why(const firmware::ReplayOptions& options) {
  return message_of<firmware::InputError>([&] { static_cast<void>(replay_log(hall().log, options)); });
}

}  // namespace sortie::testing
