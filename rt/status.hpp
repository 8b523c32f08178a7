// SPDX-License-Identifier: BSD-3-Clause
// The one error type of the real-time path: a value that must be looked at, never an exception.
#pragma once

#include <cstdint>

namespace sortie {

/// Result of a real-time call. Each value other than `ok` has a counter somewhere that counts it.
enum class [[nodiscard]] Status : std::uint8_t{
    ok = 0,
    empty,           ///< nothing to take: not an error, ask again later
    full,            ///< no room: the item was refused before it was admitted
    not_finite,      ///< a NaN or an infinity in the input; nothing was changed
    out_of_range,    ///< a finite value outside the declared range; nothing was changed
    time_backwards,  ///< the stamp lies before one already taken; nothing was changed
    time_repeated,   ///< the stamp equals one already taken; nothing was changed
    stale,           ///< the input is older than its rule allows
    malformed,       ///< bytes that do not have the declared form
    bad_checksum,    ///< form is right, content is not
    disconnected,    ///< the other side is gone (bus off, socket closed)
    not_supported,   ///< this platform or build does not have it
};

/// The name of a status as it is shown to a person. Cost: one table look-up. Never fails.
constexpr const char* to_string(Status status) {
  switch (status) {
    case Status::ok:
      return "ok";
    case Status::empty:
      return "empty";
    case Status::full:
      return "full";
    case Status::not_finite:
      return "not finite";
    case Status::out_of_range:
      return "out of range";
    case Status::time_backwards:
      return "time runs backwards";
    case Status::time_repeated:
      return "time stands still";
    case Status::stale:
      return "stale";
    case Status::malformed:
      return "malformed";
    case Status::bad_checksum:
      return "bad checksum";
    case Status::disconnected:
      return "disconnected";
    case Status::not_supported:
      return "not supported";
  }
  return "unknown status";
}

}  // namespace sortie
