// SPDX-License-Identifier: BSD-3-Clause
// How far ahead a run's start must lie. How long a thread takes to be made and made ready differs by a
// thousand times between a desktop and a small board that has just booted: it is measured, not assumed.
#pragma once

#include <cstddef>

#include "rt/time.hpp"

namespace sortie::rt::posix {

/// Stack that a worker touches before its first job.
inline constexpr std::size_t kPaintedStackBytes = std::size_t{256} * 1024;
/// Stack of each thread of a run whose memory is locked.
inline constexpr std::size_t kThreadStackBytes = std::size_t{1024} * 1024;

/// Time from now within which `threads` threads are made, one after the other, and are ready: 100 ms, and for
/// each four times the slowest of three threads like them, which are started and ended here; 5 s at most.
/// With `realtime` each touches the stack that a worker touches, and has 150 ms at least: buffers that are
/// made meanwhile are cleared and locked before their owner gets on, which no thread on trial shows. Not for
/// the real-time path. Throws ThreadRefused when no thread can be made.
Nanoseconds measure_start_lead(unsigned threads, bool realtime);

}  // namespace sortie::rt::posix
