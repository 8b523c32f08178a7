// SPDX-License-Identifier: BSD-3-Clause
// The emergency stop's button on the bus, and a board's line: what cannot be read counts as pressed.
#include "drivers/emergency_button.hpp"

#include <catch2/catch.hpp>

#include "drivers/can_frames.hpp"
#include "drivers/gpio_line.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {
constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
}

TEST_CASE("an emergency button is what its newest frame says") {
  EmergencyButton button;
  CHECK_FALSE(button.decide(0));
  CHECK(button.take(encode_emergency_button(true, 0), 0));
  CHECK(button.decide(0));
  CHECK(button.decide(1'000'000 * kMs));  // until it says otherwise
  CHECK(button.take(encode_emergency_button(false, 1), 0));
  CHECK_FALSE(button.decide(0));
  CanFrame other;
  other.id = kCanDriveId;
  CHECK_FALSE(button.take(other, 0));
}

TEST_CASE("an emergency button that cannot be read counts as pressed") {
  for (int state = 0; state < 256; ++state) {
    EmergencyButton button;
    CanFrame frame = encode_emergency_button(false, 7);
    frame.data[0] = static_cast<std::uint8_t>(state);
    CHECK(button.take(frame, 0));
    CHECK(button.decide(0) == (state != 0x55));
    CHECK(button.malformed() == (state != 0x55 && state != 0xAA ? 1u : 0u));
  }
  EmergencyButton button;
  CanFrame frame = encode_emergency_button(false, 0);
  frame.size = 1;
  CHECK(button.take(frame, 0));
  CHECK(button.decide(0));
  CHECK(button.take(encode_emergency_button(false, 1), 0));
  CHECK_FALSE(button.decide(0));
  frame.size = 2;
  frame.flags = kCanRemote;
  CHECK(button.take(frame, 0));
  CHECK(button.decide(0));
}

TEST_CASE("an emergency button that must speak is pressed before it does, and when it falls silent") {
  EmergencyButton button({.silence_ns = 100 * kMs});
  CHECK(button.decide(0));
  CHECK(button.take(encode_emergency_button(false, 0), 10 * kMs));
  CHECK_FALSE(button.decide(110 * kMs));
  CHECK(button.decide(111 * kMs));
  CHECK(button.take(encode_emergency_button(false, 1), 200 * kMs));
  CHECK_FALSE(button.decide(200 * kMs));
}

TEST_CASE("a line that is not there is refused with a cure, and cannot be read") {
  GpioLine line;
  std::string problem;
  CHECK(line.open({.chip = "/dev/no-such-gpiochip"}, problem) != Status::ok);
  CHECK(problem.size() > 20);
  CHECK_FALSE(line.is_open());
  bool active = true;
  CHECK(line.read(active) == Status::disconnected);
  CHECK(line.open({.chip = "/dev/null"}, problem) != Status::ok);  // no chip
  CHECK(active);
}

TEST_CASE("a press that ended before anybody looked counts once") {
  EmergencyButton button;
  CHECK(button.take(encode_emergency_button(true, 0), 0));
  CHECK(button.take(encode_emergency_button(false, 1), kMs));
  CHECK(button.decide(kMs));
  CHECK_FALSE(button.decide(kMs));
}

TEST_CASE("a button whose counter stands says nothing but a press") {
  EmergencyButton button({.silence_ns = 100 * kMs});
  CHECK(button.take(encode_emergency_button(false, 7), 0));
  CHECK(button.take(encode_emergency_button(false, 7), 90 * kMs));
  CHECK(button.repeated() == 1);
  CHECK_FALSE(button.decide(100 * kMs));
  CHECK(button.decide(101 * kMs));  // the node hangs
  CHECK(button.take(encode_emergency_button(true, 7), 110 * kMs));
  CHECK(button.take(encode_emergency_button(false, 7), 120 * kMs));
  CHECK(button.decide(120 * kMs));
  CHECK(button.take(encode_emergency_button(false, 8), 130 * kMs));
  CHECK_FALSE(button.decide(130 * kMs));
}
