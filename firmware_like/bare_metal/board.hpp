// SPDX-License-Identifier: BSD-3-Clause
// The little that a bare board must offer: a recording to read, a line to write, a counter. One
// implementation speaks ARM semihosting, the other stdio, so that the same program runs on a desktop.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sortie::bare {

/// Opens the recording. False: there is none.
bool open_recording();
/// Reads up to `size` bytes; fewer at its end.
std::size_t read_recording(void* bytes, std::size_t size);
/// Writes text as it is.
void print(const char* text);
/// Ends the program.
[[noreturn]] void stop(int code);

/// Marks the stack that is free now; first thing in main.
void paint_stack();
/// Most bytes of stack that were in use since; 0 where nobody knows.
std::uint32_t stack_bytes();

/// Starts the counter; counts_since_start() counts in steps of counts_per_second() and wraps at 2^24.
void start_counter();
std::uint32_t counter();
/// Steps from `before` to `after`, less than 2^24.
inline std::uint32_t counted(std::uint32_t before, std::uint32_t after) {
  return (after - before) & 0xFFFFFFu;
}

}  // namespace sortie::bare
