// SPDX-License-Identifier: BSD-3-Clause
// What a live run tells while it goes on: steps of the ladder, stuck tasks, broken promises.
#pragma once

#include <cstdint>

#include "rt/time.hpp"

namespace sortie::rt::posix {

/// Kinds of events.
enum class LiveEventKind : std::uint8_t {
  ladder,   ///< `core` took another level: `value`
  stuck,    ///< task `task` of `group` runs for longer than a period; `value`: microseconds so far
  unstuck,  ///< it has ended after all; `value`: microseconds that it was stuck for at least
  promise,  ///< `group` broke its (m,k) promise; `value`: times so far
  stop      ///< `group` was late and its policy is to stop the run
};

/// One event. Plain; crosses threads in a ring.
struct LiveEvent {
  LiveEventKind kind{};
  std::int16_t core{-1};
  std::uint16_t group{};
  std::uint16_t task{};  ///< index within the group
  Tick tick{};
  std::int64_t value{};
};

}  // namespace sortie::rt::posix
