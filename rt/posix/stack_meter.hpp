// SPDX-License-Identifier: BSD-3-Clause
// How deep a thread's stack has been: the free part is painted at the start, and looked at when the thread
// ends. Costs nothing in between.
#pragma once

#include <cstddef>
#include <cstdint>

#include "rt/posix/realtime.hpp"

namespace sortie::rt::posix {

/// Meter of one thread's stack. Paint and read on that thread.
class StackMeter {
 public:
  /// Paints `bytes` of stack below the caller; they are in memory afterwards, as after prefault_stack.
  /// Refused when that is more than what is left, less 64 kB.
  SetupResult paint(std::size_t bytes) noexcept;

  /// Most bytes of the thread's stack in use at any time since paint(), everything above the caller of
  /// paint() included. 0 before. Cost: one pass over the unused bytes.
  std::size_t high_water() const noexcept;

  /// Largest high_water() that can be told: within 1 KiB of it, the stack may have been deeper.
  std::size_t limit() const noexcept { return above_ + painted_; }

 private:
  std::uintptr_t lowest_{};  ///< address of the lowest painted byte
  std::size_t painted_{};    ///< bytes from there up to the caller of paint()
  std::size_t above_{};      ///< bytes from there up to the end of the stack
};

}  // namespace sortie::rt::posix
