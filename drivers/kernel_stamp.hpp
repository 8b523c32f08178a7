// SPDX-License-Identifier: BSD-3-Clause
// When the kernel took a datagram, on CLOCK_MONOTONIC. Internal to the drivers on sockets; Linux.
#pragma once

#include <sys/socket.h>
#include <time.h>

#include <cstdint>
#include <cstring>
#include <limits>

#include "rt/posix/clock.hpp"

namespace sortie::drivers {

/// What the kernel says beside a datagram, if SO_TIMESTAMPNS and SO_RXQ_OVFL are set.
struct KernelNote {
  rt::Nanoseconds stamp_ns{};  ///< of arrival, CLOCK_MONOTONIC; now, where the kernel gives no stamp
  bool counts_overruns{};      ///< the next is valid
  std::uint32_t overruns{};    ///< datagrams that the socket had no room for, so far; wraps
};

/// Room for those two beside a message.
inline constexpr std::size_t kKernelNoteBytes =
    CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t)) + 64;

/// Reads the note of a message that recvmsg() has filled. The kernel's stamp is of CLOCK_REALTIME; what has
/// passed since is taken off the monotonic clock, so setting the date does no harm. No stamp lies in the
/// future. Cost: three readings of clocks, nine where the thread is interrupted between them each time.
inline KernelNote read_kernel_note(msghdr& message) noexcept {
  const auto to_ns = [](const timespec& t) {
    return static_cast<rt::Nanoseconds>(t.tv_sec) * rt::kNanosecondsPerSecond + t.tv_nsec;
  };
  // Whoever is interrupted between the two clocks would blame it on the stamp: the narrowest of three looks
  // counts.
  rt::Nanoseconds now_ns = rt::posix::monotonic_now();
  rt::Nanoseconds utc_ns = now_ns;
  rt::Nanoseconds narrowest = std::numeric_limits<rt::Nanoseconds>::max();
  rt::Nanoseconds before = now_ns;
  for (int look = 0; look < 3 && narrowest > 2000; ++look) {
    const rt::Nanoseconds utc = rt::posix::read_clock(CLOCK_REALTIME);
    const rt::Nanoseconds after = rt::posix::monotonic_now();
    if (after - before < narrowest) {
      narrowest = after - before;
      now_ns = before;
      utc_ns = utc;
    }
    before = after;
  }
  KernelNote note{now_ns, false, 0};
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SCM_TIMESTAMPNS) {
      timespec t{};
      std::memcpy(&t, CMSG_DATA(c), sizeof t);
      note.stamp_ns = now_ns - (utc_ns - to_ns(t));
      if (note.stamp_ns > now_ns) note.stamp_ns = now_ns;
    } else if (c->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&note.overruns, CMSG_DATA(c), sizeof note.overruns);
      note.counts_overruns = true;
    }
  }
  return note;
}

}  // namespace sortie::drivers
