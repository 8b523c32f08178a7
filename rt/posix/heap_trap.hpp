// SPDX-License-Identifier: BSD-3-Clause
// Proof that real-time code takes no heap memory: every malloc, new and free of an armed thread is counted.
//
// Linking sortie_heap_trap replaces the malloc family of the whole program by thin wrappers of glibc's own (a
// few ns a call). It is linked by the program and the tests, never by a library. It does not see mmap or page
// faults; those are counted by thread_page_faults().
#pragma once

#include <cstdint>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SORTIE_HEAP_TRAP 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SORTIE_HEAP_TRAP 0
#endif
#endif
#ifndef SORTIE_HEAP_TRAP
#ifdef __GLIBC__
#define SORTIE_HEAP_TRAP 1
#else
#define SORTIE_HEAP_TRAP 0
#endif
#endif

namespace sortie::rt::posix {

/// False where nothing is counted: under a sanitizer, which owns malloc, and without glibc.
inline constexpr bool kHeapTrapAvailable = SORTIE_HEAP_TRAP != 0;

/// What a heap call of an armed thread does.
enum class HeapTrapAction : std::uint8_t {
  count,  ///< is counted and goes on
  abort,  ///< prints a backtrace to stderr and aborts: for finding the place
};

/// For all threads; `count` at start.
void set_heap_trap_action(HeapTrapAction action) noexcept;

/// Heap calls of all threads while they were armed, since the start of the program.
std::uint64_t heap_trap_calls() noexcept;

/// Heap calls of this thread while it was armed, since the thread began.
std::uint64_t heap_trap_thread_calls() noexcept;

/// Arms this thread, as often as it is called; each call needs one heap_trap_disarm(). See HeapTrapScope.
void heap_trap_arm() noexcept;
/// Takes back one heap_trap_arm().
void heap_trap_disarm() noexcept;

/// Arms the calling thread while it lives. May be nested.
class [[nodiscard]] HeapTrapScope {
 public:
  HeapTrapScope() noexcept : before_(heap_trap_thread_calls()) { heap_trap_arm(); }
  ~HeapTrapScope() { heap_trap_disarm(); }
  HeapTrapScope(const HeapTrapScope&) = delete;
  HeapTrapScope& operator=(const HeapTrapScope&) = delete;

  /// Heap calls of this thread since this scope began.
  std::uint64_t calls() const noexcept { return heap_trap_thread_calls() - before_; }

 private:
  std::uint64_t before_;
};

}  // namespace sortie::rt::posix
