// SPDX-License-Identifier: BSD-3-Clause
// The malloc family of the program, counted while a thread is armed, done by glibc's own.
#include "rt/posix/heap_trap.hpp"

#include <atomic>

#if SORTIE_HEAP_TRAP

#include <execinfo.h>
#include <malloc.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstddef>

// glibc's own names for its allocator.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void __libc_free(void*);
void* __libc_memalign(std::size_t, std::size_t);
void* __libc_valloc(std::size_t);
void* __libc_pvalloc(std::size_t);
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace {

// Initial-exec storage lies in the thread's static block: the general model may call malloc on first touch.
[[gnu::tls_model("initial-exec")]] constinit thread_local std::uint32_t armed_depth = 0;
[[gnu::tls_model("initial-exec")]] constinit thread_local std::uint64_t thread_calls = 0;
constinit std::atomic<std::uint64_t> all_calls{0};
constinit std::atomic<sortie::rt::posix::HeapTrapAction> chosen_action{
    sortie::rt::posix::HeapTrapAction::count};

[[gnu::cold, gnu::noinline]] void trapped() noexcept {
  ++thread_calls;
  all_calls.fetch_add(1, std::memory_order_relaxed);
  if (chosen_action.load(std::memory_order_relaxed) != sortie::rt::posix::HeapTrapAction::abort) return;
  armed_depth = 0;  // the backtrace may allocate
  static constexpr char kMessage[] = "heap trap: a real-time thread called the heap here:\n";
  static_cast<void>(!write(STDERR_FILENO, kMessage, sizeof(kMessage) - 1));
  void* frames[32];
  backtrace_symbols_fd(frames, backtrace(frames, 32), STDERR_FILENO);
  std::abort();
}

inline void check() noexcept {
  if (__builtin_expect(armed_depth != 0, 0)) trapped();
}

}  // namespace

extern "C" {

void* malloc(std::size_t bytes) noexcept {
  check();
  return __libc_malloc(bytes);
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  check();
  return __libc_calloc(count, bytes);
}

void* realloc(void* old, std::size_t bytes) noexcept {
  check();
  return __libc_realloc(old, bytes);
}

void* reallocarray(void* old, std::size_t count, std::size_t bytes) noexcept {
  check();
  std::size_t total = 0;
  if (__builtin_mul_overflow(count, bytes, &total)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_realloc(old, total);
}

// Freeing nothing is no heap call.
void free(void* old) noexcept {
  if (old == nullptr) return;
  check();
  __libc_free(old);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  check();
  return __libc_memalign(alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  check();
  return __libc_memalign(alignment, bytes);
}

int posix_memalign(void** out, std::size_t alignment, std::size_t bytes) noexcept {
  check();
  if (!std::has_single_bit(alignment) || alignment % sizeof(void*) != 0) return EINVAL;
  void* const memory = __libc_memalign(alignment, bytes);
  if (memory == nullptr) return ENOMEM;
  *out = memory;
  return 0;
}

void* valloc(std::size_t bytes) noexcept {
  check();
  return __libc_valloc(bytes);
}

void* pvalloc(std::size_t bytes) noexcept {
  check();
  return __libc_pvalloc(bytes);
}

}  // extern "C"

namespace sortie::rt::posix {

void set_heap_trap_action(HeapTrapAction action) noexcept {
  chosen_action.store(action, std::memory_order_relaxed);
}
std::uint64_t heap_trap_calls() noexcept { return all_calls.load(std::memory_order_relaxed); }
std::uint64_t heap_trap_thread_calls() noexcept { return thread_calls; }
void heap_trap_arm() noexcept { ++armed_depth; }
void heap_trap_disarm() noexcept {
  if (armed_depth != 0) --armed_depth;
}

}  // namespace sortie::rt::posix

#else

namespace sortie::rt::posix {

void set_heap_trap_action(HeapTrapAction) noexcept {}
std::uint64_t heap_trap_calls() noexcept { return 0; }
std::uint64_t heap_trap_thread_calls() noexcept { return 0; }
void heap_trap_arm() noexcept {}
void heap_trap_disarm() noexcept {}

}  // namespace sortie::rt::posix

#endif
