// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/heap_count.hpp"

#include <cstdlib>
#include <new>

namespace {
std::uint64_t calls_of_new = 0;
}  // namespace

void* operator new(std::size_t size) {
  ++calls_of_new;
  if (void* const p = std::malloc(size > 0 ? size : 1); p != nullptr) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace sortie::bench {
std::uint64_t heap_calls() { return calls_of_new; }
}  // namespace sortie::bench
