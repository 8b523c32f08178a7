// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/stack_meter.hpp"

#include <pthread.h>

namespace sortie::rt::posix {
namespace {

// Unlikely as a number, an address or a flag.
constexpr std::uint64_t kPaint = 0xb5c0'fbcf'e9b5'dba5u;
// Kept free for this function's own frame and those that it calls while it paints.
constexpr std::size_t kOwnFrame = 1024;
constexpr std::size_t kReserve = std::size_t{64} * 1024;

volatile std::uint64_t* word_at(std::uintptr_t address) {
  return reinterpret_cast<volatile std::uint64_t*>(address);  // NOLINT(performance-no-int-to-ptr)
}

}  // namespace

[[gnu::noinline, gnu::no_sanitize_address]] SetupResult StackMeter::paint(std::size_t bytes) noexcept {
  pthread_attr_t attributes;
  void* lowest = nullptr;
  std::size_t size = 0;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0)
    return refusal("stack meter: the stack's bounds are not known");
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);

  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  const auto bottom = reinterpret_cast<std::uintptr_t>(lowest);
  const std::size_t left = here > bottom ? static_cast<std::size_t>(here - bottom) : 0;
  if (left < kReserve + kOwnFrame || bytes > left - kReserve - kOwnFrame) {
    return refusal("stack meter: %zu bytes wanted, %zu left; ask for less or raise 'ulimit -s'", bytes, left);
  }
  const std::uintptr_t top = (here - kOwnFrame) / 8 * 8;
  // Downwards, as deep calls would: the kernel grows the main thread's stack on touch.
  std::uintptr_t at = top;
  for (std::size_t done = 0; done + 8 <= bytes; done += 8) *word_at(at -= 8) = kPaint;
  lowest_ = at;
  painted_ = static_cast<std::size_t>(here - at);
  above_ = static_cast<std::size_t>(bottom + size - here);
  return {};
}

[[gnu::noinline, gnu::no_sanitize_address]] std::size_t StackMeter::high_water() const noexcept {
  if (painted_ == 0) return 0;
  std::size_t untouched = 0;
  while (untouched + kOwnFrame < painted_ && *word_at(lowest_ + untouched) == kPaint) untouched += 8;
  return limit() - untouched;
}

}  // namespace sortie::rt::posix
