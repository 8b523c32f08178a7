// SPDX-License-Identifier: BSD-3-Clause
// CANopen's messages against bytes written out by hand from CiA 301, and against garbage.
#include <catch2/catch.hpp>
#include <cstring>
#include <initializer_list>
#include <random>

#include "drivers/canopen/cia402.hpp"
#include "drivers/canopen/drive_setup.hpp"
#include "drivers/canopen/frames.hpp"
#include "drivers/canopen/sdo_client.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

CanFrame canopen_frame(std::uint32_t id, std::initializer_list<unsigned> bytes) {
  CanFrame frame;
  frame.id = id;
  for (unsigned byte : bytes) frame.data[frame.size++] = static_cast<std::uint8_t>(byte);
  return frame;
}

bool canopen_same(const CanFrame& a, const CanFrame& b) {
  return a.id == b.id && a.size == b.size && a.flags == b.flags && std::memcmp(a.data, b.data, 8) == 0;
}

}  // namespace

TEST_CASE("canopen: messages are the bytes of the standard") {
  CHECK(canopen_same(canopen::encode_nmt(canopen::NmtCommand::start, 5), canopen_frame(0x000, {0x01, 0x05})));
  CHECK(canopen_same(canopen::encode_nmt(canopen::NmtCommand::pre_operational, 0),
                     canopen_frame(0x000, {0x80, 0x00})));
  CHECK(canopen_same(canopen::encode_sync(), canopen_frame(0x080, {})));
  CHECK(canopen_same(canopen::encode_heartbeat(0x7F, canopen::NmtState::operational),
                     canopen_frame(0x77F, {0x05})));
  CHECK(canopen_same(canopen::encode_emergency(3, {0x8130, 0x11}),
                     canopen_frame(0x083, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0})));
  // Write 1F4h, two bytes, to 1017h:0 of node 2; its answer; a read of 1000h:0 and its answer; an abort.
  CHECK(canopen_same(canopen::encode_sdo_request(2, {canopen::SdoKind::write, {0x1017, 0}, 0x1F4, 2}),
                     canopen_frame(0x602, {0x2B, 0x17, 0x10, 0x00, 0xF4, 0x01, 0x00, 0x00})));
  CHECK(canopen_same(canopen::encode_sdo_reply(2, {canopen::SdoKind::written, {0x1017, 0}, 0, 0}),
                     canopen_frame(0x582, {0x60, 0x17, 0x10, 0, 0, 0, 0, 0})));
  CHECK(canopen_same(canopen::encode_sdo_request(2, {canopen::SdoKind::read, {0x1000, 0}, 0, 0}),
                     canopen_frame(0x602, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0})));
  CHECK(canopen_same(canopen::encode_sdo_reply(2, {canopen::SdoKind::value, {0x1000, 0}, 0x00020192, 4}),
                     canopen_frame(0x582, {0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00})));
  CHECK(canopen_same(
      canopen::encode_sdo_reply(2, {canopen::SdoKind::abort, {0x6099, 1}, canopen::kAbortNoObject, 0}),
      canopen_frame(0x582, {0x80, 0x99, 0x60, 0x01, 0x00, 0x00, 0x02, 0x06})));
}

TEST_CASE("canopen: an SDO is read back as it was written, for every size") {
  for (std::uint8_t bytes = 0; bytes <= 4; ++bytes) {
    const std::uint32_t value = 0x89AB'CDEFu >> (bytes == 0 ? 0u : 8u * (4u - bytes));
    const canopen::Sdo sent{canopen::SdoKind::write, {0x60C2, 7}, value, bytes};
    canopen::Sdo read;
    std::uint8_t node = 0;
    REQUIRE(canopen::decode_sdo_request(canopen::encode_sdo_request(9, sent), node, read) == Status::ok);
    CHECK(node == 9);
    CHECK(read.kind == canopen::SdoKind::write);
    CHECK(read.key == sent.key);
    CHECK(read.bytes == bytes);
    CHECK(read.value == value);
  }
}

TEST_CASE("canopen: what does not have the form is refused and changes nothing") {
  canopen::NmtState state = canopen::NmtState::stopped;
  std::uint8_t node = 42;
  CHECK(canopen::decode_heartbeat(canopen_frame(0x705, {}), node, state) == Status::malformed);
  CHECK(canopen::decode_heartbeat(canopen_frame(0x705, {5, 0}), node, state) == Status::malformed);
  CHECK(canopen::decode_heartbeat(canopen_frame(0x705, {6}), node, state) == Status::malformed);
  CHECK(canopen::decode_heartbeat(canopen_frame(0x700, {5}), node, state) == Status::not_supported);
  CanFrame extended = canopen_frame(0x705, {5});
  extended.flags = kCanExtended;
  CHECK(canopen::decode_heartbeat(extended, node, state) == Status::not_supported);
  canopen::Sdo sdo;
  CHECK(canopen::decode_sdo_reply(canopen_frame(0x582, {0x60, 0x17, 0x10}), node, sdo) == Status::malformed);
  // The beginning of a segmented transfer; a size that contradicts itself; a reserved bit.
  CHECK(canopen::decode_sdo_reply(canopen_frame(0x582, {0x41, 8, 0x10, 0, 9, 0, 0, 0}), node, sdo) ==
        Status::not_supported);
  CHECK(canopen::decode_sdo_reply(canopen_frame(0x582, {0x46, 8, 0x10, 0, 9, 0, 0, 0}), node, sdo) ==
        Status::malformed);
  CHECK(canopen::decode_sdo_reply(canopen_frame(0x582, {0x53, 8, 0x10, 0, 9, 0, 0, 0}), node, sdo) ==
        Status::malformed);
  CHECK(node == 42);
  CHECK(state == canopen::NmtState::stopped);
  CHECK(sdo.key == canopen::ObjectKey{});
  canopen::NmtCommand command = canopen::NmtCommand::stop;
  CHECK(canopen::decode_nmt(canopen_frame(0, {3, 1}), command, node) == Status::malformed);
  CHECK(canopen::decode_nmt(canopen_frame(0, {1, 128}), command, node) == Status::malformed);
  CHECK(canopen::decode_nmt(canopen_frame(0, {1}), command, node) == Status::malformed);
}

TEST_CASE("canopen: decoders answer every frame, and what they accept encodes to the same message") {
  const unsigned seed = 20260;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  int accepted = 0;
  for (int i = 0; i < 200'000; ++i) {
    CanFrame frame;
    const std::uint32_t bases[] = {0, 0x80, 0x180, 0x580, 0x600, 0x700};
    frame.id = bases[random() % 6] + static_cast<std::uint32_t>(random() % 130);
    frame.size = static_cast<std::uint8_t>(random() % 9);
    for (std::uint8_t k = 0; k < frame.size; ++k) frame.data[k] = static_cast<std::uint8_t>(random() & 0xFFu);
    if (random() % 2 == 0) frame.data[0] = 0x23;  // else hardly one is a write of four bytes
    std::uint8_t node = 0;
    canopen::NmtState state{};
    canopen::Sdo sdo;
    if (canopen::decode_heartbeat(frame, node, state) == Status::ok) {
      CHECK(canopen_same(canopen::encode_heartbeat(node, state), frame));
      ++accepted;
    }
    if (canopen::decode_sdo_request(frame, node, sdo) == Status::ok && sdo.kind == canopen::SdoKind::write &&
        sdo.bytes == 4) {
      CHECK(canopen_same(canopen::encode_sdo_request(node, sdo), frame));
      ++accepted;
    }
  }
  CHECK(accepted > 1000);
}

TEST_CASE("canopen: status words of the profile are named, and every other pattern is unknown") {
  using canopen::DriveState;
  // CiA 402, table of states; x = either.
  CHECK(canopen::drive_state(0x0210) == DriveState::not_ready);
  CHECK(canopen::drive_state(0x0250) == DriveState::switch_on_disabled);
  CHECK(canopen::drive_state(0x0231) == DriveState::ready_to_switch_on);
  CHECK(canopen::drive_state(0x0233) == DriveState::switched_on);
  CHECK(canopen::drive_state(0x1637) == DriveState::operation_enabled);
  CHECK(canopen::drive_state(0x0217) == DriveState::quick_stop);
  CHECK(canopen::drive_state(0x021F) == DriveState::fault_reaction);
  CHECK(canopen::drive_state(0x0218) == DriveState::fault);
  CHECK(canopen::drive_state(0x0022) == DriveState::unknown);
  CHECK(canopen::drive_state(0x0041) == DriveState::unknown);
}

TEST_CASE("canopen: an SDO client repeats, gives up, and is not taken in by an answer to another question") {
  constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
  canopen::SdoClient client(4);
  client.read({0x1000, 0});
  CHECK_FALSE(client.take({canopen::SdoKind::value, {0x1000, 0}, 402, 4}));  // nobody has been asked yet
  CanFrame frame;
  int asked = 0;
  rt::Nanoseconds last = 0;
  for (rt::Nanoseconds now = 0; now < 1000 * kMs; now += kMs) {
    if (!client.poll(now, frame)) continue;
    CHECK(frame.id == 0x604);
    if (asked > 0) CHECK(now - last == 100 * kMs);
    client.sent(now);
    last = now;
    ++asked;
    CHECK_FALSE(client.take({canopen::SdoKind::value, {0x1001, 0}, 1, 1}));
    CHECK_FALSE(client.take({canopen::SdoKind::written, {0x1000, 0}, 0, 0}));
  }
  CHECK(asked == 3);
  CHECK(client.result().progress == canopen::SdoProgress::timed_out);
  // What could not be sent is offered again and is no attempt.
  client.write({0x6060, 0}, 3, 1);
  for (int i = 0; i < 50; ++i) CHECK(client.poll(i * 100 * kMs, frame));
  client.sent(5000 * kMs);
  CHECK(client.take({canopen::SdoKind::abort, {0x6060, 0}, canopen::kAbortReadOnly, 0}));
  CHECK(client.result().progress == canopen::SdoProgress::aborted);
  CHECK(client.result().value == canopen::kAbortReadOnly);
}

TEST_CASE("canopen: settings that cannot work are refused before anything moves") {
  canopen::DriveConfig config;
  CHECK_NOTHROW(canopen::DriveSetup(config));
  config.node = 127;
  CHECK_THROWS_WITH(canopen::DriveSetup(config), Catch::Contains("node numbers"));
  config = {};
  config.heartbeat_timeout_ns = config.heartbeat_ns;
  CHECK_THROWS_WITH(canopen::DriveSetup(config), Catch::Contains("heartbeat_timeout"));
  config = {};
  config.sync_period_ns = 1'500'000;
  CHECK_THROWS_WITH(canopen::DriveSetup(config), Catch::Contains("whole milliseconds"));
}
