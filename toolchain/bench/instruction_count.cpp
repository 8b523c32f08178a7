// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/instruction_count.hpp"

#if __has_include(<valgrind/callgrind.h>) && __has_include(<valgrind/valgrind.h>)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#include <valgrind/callgrind.h>
#include <valgrind/valgrind.h>
#define SORTIE_HAS_VALGRIND 1
#else
#define SORTIE_HAS_VALGRIND 0
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SORTIE_HAS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SORTIE_HAS_SANITIZER 1
#endif
#endif

namespace sortie::toolchain {

const char* why_not_counting() {
#ifdef SORTIE_HAS_SANITIZER
  return "this program was built with a sanitizer, which callgrind cannot run; use the release build";
#else
  return SORTIE_HAS_VALGRIND != 0
             ? nullptr
             : "this program was built without valgrind's headers and cannot count instructions; "
               "apt-get install valgrind, then configure and build again";
#endif
}

#if SORTIE_HAS_VALGRIND
void start_counting() { CALLGRIND_START_INSTRUMENTATION; }
void mark_count() { static_cast<void>(VALGRIND_MONITOR_COMMAND("status internal")); }
#pragma GCC diagnostic pop
#else
void start_counting() {}
void mark_count() {}
#endif

}  // namespace sortie::toolchain
