// SPDX-License-Identifier: BSD-3-Clause
// A fuzz target whose faults are planted: planted_test.py sees the driver find each one.
#include <unistd.h>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string_view>

namespace {

volatile int sink = 0;
void* volatile memory = nullptr;

int deep(int level) {
  volatile char room[4096] = {};
  room[level % 4096] = 1;
  return level > 0 ? deep(level + 1) + room[0] : 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (text == "boom") std::abort();
  if (text == "throw") throw std::runtime_error("planted");
  if (text == "read behind the end") sink = data[size];
  if (text == "overflow") sink = std::numeric_limits<int>::max() - sink + static_cast<int>(size);
  if (text == "write to nowhere") *reinterpret_cast<volatile char*>(size) = 1;
  if (text == "deep") sink = deep(1);
  if (text == "allocate") memory = std::malloc(std::size_t{3} << 30);
  if (text == "exit") std::exit(0);
  while (text == "wait") ::pause();
  return 0;
}
