// SPDX-License-Identifier: BSD-3-Clause
// The heap trap sees every way to the heap in an armed scope, and nothing outside one.
#include "rt/posix/heap_trap.hpp"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace sortie::rt::posix {
namespace {

// The compiler may leave out an allocation whose result it sees unused; what passes here it cannot see
// through.
void keep(void* memory) { asm volatile("" : : "r"(memory) : "memory"); }

template <class Work>
std::uint64_t calls_in(Work work) {
  const HeapTrapScope scope;
  work();
  return scope.calls();
}

}  // namespace

TEST_CASE("an armed scope counts each call of the malloc family") {
  if (!kHeapTrapAvailable) {
    WARN("skipped: this build has no heap trap");
    return;
  }
  void* held = nullptr;
  CHECK(calls_in([&] { keep(held = std::malloc(8)); }) == 1);
  CHECK(calls_in([&] { keep(held = std::realloc(held, 4096)); }) == 1);
  CHECK(calls_in([&] { std::free(held); }) == 1);
  CHECK(calls_in([&] { keep(held = std::calloc(3, 5)); }) == 1);
  std::free(held);
  CHECK(calls_in([&] { keep(held = std::aligned_alloc(64, 128)); }) == 1);
  CHECK(reinterpret_cast<std::uintptr_t>(held) % 64 == 0);
  std::free(held);
  CHECK(calls_in([&] { keep(held = memalign(256, 100)); }) == 1);
  CHECK(reinterpret_cast<std::uintptr_t>(held) % 256 == 0);
  std::free(held);
  int error = -1;
  CHECK(calls_in([&] { error = posix_memalign(&held, 128, 100); }) == 1);
  CHECK(error == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(held) % 128 == 0);
  std::free(held);
  CHECK(calls_in([&] { error = posix_memalign(&held, 3, 100); }) == 1);
  CHECK(error == EINVAL);
  CHECK(calls_in([] { std::free(nullptr); }) == 0);
}

TEST_CASE("an armed scope counts new, growing vectors, strings and throws") {
  if (!kHeapTrapAvailable) {
    WARN("skipped: this build has no heap trap");
    return;
  }
  struct alignas(128) Wide {
    char bytes[128];
  };
  int* number = nullptr;
  Wide* wide = nullptr;
  CHECK(calls_in([&] { keep(number = new int(1)); }) == 1);
  CHECK(calls_in([&] { delete number; }) == 1);
  CHECK(calls_in([&] { keep(wide = new Wide); }) == 1);
  delete wide;

  std::vector<int> vector;
  vector.reserve(4);
  CHECK(calls_in([&] { vector.assign(4, 1); }) == 0);
  CHECK(calls_in([&] { vector.push_back(5); }) == 2);  // the new block, and the old one back
  CHECK(calls_in([] {
          std::string text(100, 'x');
          keep(text.data());
        }) == 2);
  CHECK(calls_in([] {
          try {
            throw 1;
          } catch (int) {
          }
        }) > 0);
}

TEST_CASE("scopes nest, and only their own thread is armed") {
  if (!kHeapTrapAvailable) {
    WARN("skipped: this build has no heap trap");
    return;
  }
  const std::uint64_t before = heap_trap_calls();
  {
    const HeapTrapScope outer;
    std::uint64_t inner_calls = 0;
    {
      const HeapTrapScope inner;
      const std::unique_ptr<int> one = std::make_unique<int>(1);
      keep(one.get());
      inner_calls = inner.calls();
    }
    const std::uint64_t outer_calls = outer.calls();
    keep(std::malloc(1));  // the inner scope's end has not disarmed the thread
    const std::uint64_t later_calls = outer.calls();
    CHECK(inner_calls == 1);
    CHECK(outer_calls == 2);
    CHECK(later_calls == 3);
  }
  CHECK(heap_trap_calls() > before);

  const std::uint64_t outside = heap_trap_thread_calls();
  std::vector<int> grown;
  for (int i = 0; i < 100; ++i) grown.push_back(i);
  CHECK(heap_trap_thread_calls() == outside);

  std::uint64_t other_threads_calls = 1;
  {
    const HeapTrapScope armed_here;
    std::thread other([&other_threads_calls] {
      keep(std::malloc(7));
      other_threads_calls = heap_trap_thread_calls();
    });
    other.join();
  }
  CHECK(other_threads_calls == 0);
}

TEST_CASE("in abort mode the first heap call of an armed thread ends the program") {
  if (!kHeapTrapAvailable) {
    WARN("skipped: this build has no heap trap");
    return;
  }
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    std::signal(SIGABRT, SIG_DFL);
    close(STDERR_FILENO);
    set_heap_trap_action(HeapTrapAction::abort);
    keep(std::malloc(1));  // not armed: goes on
    const HeapTrapScope scope;
    keep(std::malloc(1));
    _exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFSIGNALED(status));
  CHECK(WTERMSIG(status) == SIGABRT);
}

}  // namespace sortie::rt::posix
