// SPDX-License-Identifier: BSD-3-Clause
// The stack meter tells how deep a thread has been.
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <thread>

#include "rt/posix/stack_meter.hpp"

namespace sortie::rt::posix {
namespace {

constexpr std::size_t kKiB = 1024;

// Uses about `kilobytes` of stack in frames of 1 KiB.
[[gnu::noinline]] int go_down(int kilobytes) {
  volatile char frame[kKiB];
  for (std::size_t i = 0; i < sizeof(frame); i += 64) frame[i] = static_cast<char>(i);
  const int below = kilobytes > 1 ? go_down(kilobytes - 1) : 0;
  return below + frame[0];
}

}  // namespace

TEST_CASE("the stack meter tells the depth to a kilobyte and forgets nothing") {
  std::size_t shallow = 0;
  std::size_t deep = 0;
  std::size_t later = 0;
  std::size_t limit = 0;
  SetupResult painted;
  std::thread([&] {
    StackMeter meter;
    painted = meter.paint(256 * kKiB);
    limit = meter.limit();
    shallow = meter.high_water();
    static_cast<void>(go_down(100));
    deep = meter.high_water();
    static_cast<void>(go_down(10));
    later = meter.high_water();
  }).join();
  REQUIRE(painted.ok);
#if defined(__SANITIZE_ADDRESS__)
  WARN("skipped: the address sanitizer keeps locals elsewhere");
  return;
#endif
  INFO("shallow " << shallow << " deep " << deep << " of " << limit);
  CHECK(shallow > 0);
  CHECK(shallow + 256 * kKiB <= limit + 2 * kKiB);
  CHECK(deep - shallow > 95 * kKiB);
  CHECK(deep - shallow < 140 * kKiB);  // frames have an edge of their own, more so where nothing is optimised
  CHECK(later == deep);
  CHECK(deep < limit);
}

TEST_CASE("a stack that goes below the paint reports its limit") {
  std::size_t used = 0;
  std::size_t limit = 1;
  std::thread([&] {
    StackMeter meter;
    CHECK(meter.high_water() == 0);
    if (!meter.paint(32 * kKiB).ok) return;
    static_cast<void>(go_down(100));
    used = meter.high_water();
    limit = meter.limit();
  }).join();
#if defined(__SANITIZE_ADDRESS__)
  WARN("skipped: the address sanitizer keeps locals elsewhere");
  return;
#endif
  CHECK(used + kKiB > limit);
  CHECK(used <= limit);
}

TEST_CASE("more paint than stack is refused with the cure") {
  StackMeter meter;
  const SetupResult result = meter.paint(std::size_t{1} << 30);
  CHECK_FALSE(result.ok);
  CHECK(std::string(result.reason).find("ulimit -s") != std::string::npos);
  CHECK(meter.high_water() == 0);
}

}  // namespace sortie::rt::posix
