// SPDX-License-Identifier: BSD-3-Clause
// The stamp gate: steady streams, repeats, steps back, wild stamps, clocks that were set anew.
#include "rt/stamp_gate.hpp"

#include <catch2/catch.hpp>
#include <limits>

namespace {
using namespace sortie;
using rt::StampGate;
constexpr rt::Nanoseconds kSecond = rt::kNanosecondsPerSecond;
}  // namespace

TEST_CASE("A steady stream passes, while repeats and steps back do not and leave the newest stamp alone") {
  StampGate gate(kSecond);
  CHECK_FALSE(gate.started());
  CHECK(gate.take(-5) == Status::ok);
  CHECK(gate.take(10) == Status::ok);
  CHECK(gate.take(10) == Status::time_repeated);
  CHECK(gate.take(9) == Status::time_backwards);
  CHECK(gate.last() == 10);
  CHECK(gate.take(10 + kSecond) == Status::ok);
  CHECK_FALSE(gate.resumed());
  CHECK(gate.take(10 + 2 * kSecond + 1) == Status::out_of_range);
  CHECK(gate.take(11 + kSecond) == Status::ok);
}

TEST_CASE("One wild stamp does not lock the stream out, whatever its value") {
  for (const rt::Nanoseconds wild :
       {std::numeric_limits<rt::Nanoseconds>::max(), std::numeric_limits<rt::Nanoseconds>::min(),
        rt::Nanoseconds{1} << 62, -(rt::Nanoseconds{1} << 62), rt::Nanoseconds{0}}) {
    StampGate gate(kSecond);
    REQUIRE(gate.take(100 * kSecond) == Status::ok);
    CHECK(gate.take(wild) != Status::ok);
    CHECK(gate.take(100 * kSecond + 1) == Status::ok);
    CHECK(gate.last() == 100 * kSecond + 1);
  }
}

TEST_CASE("A clock that was set anew is believed after eight rising stamps, in both directions") {
  for (const rt::Nanoseconds begin : {rt::Nanoseconds{0}, 1000 * kSecond}) {
    StampGate gate(kSecond, 8);
    REQUIRE(gate.take(100 * kSecond) == Status::ok);
    for (int i = 0; i < 7; ++i) REQUIRE(gate.take(begin + i) != Status::ok);
    REQUIRE(gate.take(begin + 7) == Status::ok);
    CHECK(gate.resumed());
    CHECK(gate.take(begin + 8) == Status::ok);
    CHECK_FALSE(gate.resumed());
  }
}

TEST_CASE("Doubted stamps that do not rise steadily, or good ones between them, confirm nothing") {
  StampGate gate(kSecond, 3);
  REQUIRE(gate.take(100 * kSecond) == Status::ok);
  for (int i = 0; i < 50; ++i) REQUIRE(gate.take(50 * kSecond - i) == Status::time_backwards);
  for (int i = 0; i < 50; ++i) {
    REQUIRE(gate.take(10 * kSecond + i) == Status::time_backwards);
    REQUIRE(gate.take(100 * kSecond + 1 + i) == Status::ok);
  }
}
