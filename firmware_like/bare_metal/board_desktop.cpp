// SPDX-License-Identifier: BSD-3-Clause
// The board's twin on a desktop: the same program, the same recording, the same digest.
#include <cstdio>
#include <cstdlib>

#include "firmware_like/bare_metal/board.hpp"

namespace sortie::bare {
namespace {
std::FILE* recording = nullptr;
}

bool open_recording() {
  recording = std::fopen("recording.bin", "rb");
  return recording != nullptr;
}

std::size_t read_recording(void* bytes, std::size_t size) { return std::fread(bytes, 1, size, recording); }

void print(const char* text) { std::fputs(text, stdout); }

void stop(int code) {
  std::fflush(stdout);
  std::exit(code);
}

void paint_stack() {}
std::uint32_t stack_bytes() { return 0; }
void start_counter() {}
std::uint32_t counter() { return 0; }

}  // namespace sortie::bare
