// SPDX-License-Identifier: BSD-3-Clause
// ARM semihosting (a debugger or QEMU answers), and the SysTick counter of a Cortex-M.
#include <new>

#include "firmware_like/bare_metal/board.hpp"

extern "C" char __heap_start[], __stack[];

namespace sortie::bare {
namespace {

constexpr char kPaint = 0x55;

constexpr unsigned kOpen = 0x01;
constexpr unsigned kWriteZero = 0x04;
constexpr unsigned kRead = 0x06;
constexpr unsigned kExitExtended = 0x20;
constexpr unsigned kApplicationExit = 0x20026;

// "ARM semihosting", Arm IHI 0085: operation in r0, argument in r1, answer in r0.
int call(unsigned operation, const void* argument) {
  register unsigned r0 asm("r0") = operation;
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return static_cast<int>(r0);
}

int recording = -1;

// SysTick of ARMv7-M: control, reload, current value.
volatile std::uint32_t* const kSysTick = reinterpret_cast<volatile std::uint32_t*>(0xE000E010);

}  // namespace

bool open_recording() {
  static const char name[] = "recording.bin";
  const struct {
    const char* name;
    unsigned mode, length;
  } argument{name, 1, sizeof name - 1};  // 1: "rb"
  recording = call(kOpen, &argument);
  return recording >= 0;
}

std::size_t read_recording(void* bytes, std::size_t size) {
  const struct {
    int file;
    void* bytes;
    std::size_t size;
  } argument{recording, bytes, size};
  const int left = call(kRead, &argument);  // bytes that were not read
  return left < 0 ? 0 : size - static_cast<std::size_t>(left);
}

void print(const char* text) { static_cast<void>(call(kWriteZero, text)); }

void stop(int code) {
  const unsigned argument[2] = {kApplicationExit, static_cast<unsigned>(code)};
  static_cast<void>(call(kExitExtended, argument));
  for (;;) {
  }
}

// The linker's script puts the stack above all else: from the end of the variables up to __stack.
void paint_stack() {
  char here = 0;
  for (char* at = __heap_start; at < &here - 64; ++at) *at = kPaint;
}

std::uint32_t stack_bytes() {
  const char* at = __heap_start;
  while (at < __stack && *at == kPaint) ++at;
  return static_cast<std::uint32_t>(__stack - at);
}

void start_counter() {
  kSysTick[1] = 0xFFFFFF;
  kSysTick[2] = 0;
  kSysTick[0] = 5;  // processor clock, no interrupt
}

// It counts down.
std::uint32_t counter() { return ~kSysTick[2] & 0xFFFFFFu; }

}  // namespace sortie::bare

// What asks for memory has no place on this board.
void* operator new(std::size_t) {
  sortie::bare::print("a part asked for memory that a board does not have\n");
  sortie::bare::stop(1);
}

// Virtual destructors name them; nothing is ever deleted, and so no heap is linked.
void operator delete(void*) noexcept {}
void operator delete(void*, std::size_t) noexcept {}
void operator delete(void*, std::align_val_t) noexcept {}
void operator delete(void*, std::size_t, std::align_val_t) noexcept {}
