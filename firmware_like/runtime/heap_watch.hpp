// SPDX-License-Identifier: BSD-3-Clause
// The heap trap replaces malloc for a whole program, so only a program knows of it; the library asks here.
#pragma once

#include <cstdint>

#include "rt/posix/heap_trap.hpp"

namespace sortie::firmware {

/// What a program that links a heap trap tells the library. Both null: heap calls are not counted.
struct HeapWatch {
  void (*arm)(bool on){};      ///< for the calling thread
  std::uint64_t (*calls)(){};  ///< heap calls of armed threads since the program started
};

namespace detail {
inline HeapWatch the_heap_watch;
}  // namespace detail
/// Set once at start-up, before any run.
inline void set_heap_watch(HeapWatch watch) { detail::the_heap_watch = watch; }
inline HeapWatch heap_watch() { return detail::the_heap_watch; }

/// Counts every heap call of a task from now on. For programs that link sortie_heap_trap. False where the
/// trap does not work.
inline bool watch_heap() {
  if (!rt::posix::kHeapTrapAvailable) return false;
  set_heap_watch({[](bool on) { on ? rt::posix::heap_trap_arm() : rt::posix::heap_trap_disarm(); },
                  [] { return rt::posix::heap_trap_calls(); }});
  return true;
}

}  // namespace sortie::firmware
