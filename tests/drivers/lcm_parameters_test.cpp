// SPDX-License-Identifier: BSD-3-Clause
// Messages about parameters against lcm-gen's code; tags against published values; damaged bytes.
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "drivers/siphash.hpp"
#include "drivers/wire_parameters.hpp"
#include "sortie/parameter_t.hpp"
#include "sortie/parameters_t.hpp"
#include "sortie/set_parameter_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

SipKey counting_key() {
  SipKey key{};
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(i);
  return key;
}

SetParameter some_request() { return {1, 2, 3, 4, {0, "drive.max_speed_m_s", 0.25}}; }

Bytes request_bytes(const SetParameter& request, const SipKey* key) {
  return exact([&](auto out, auto& size) { return encode(request, key, out, size); });
}

}  // namespace

TEST_CASE("SipHash-2-4 gives the values of its authors") {
  // Key 00 01 .. 0f; input 00 01 .. (length - 1); from vectors.h of the reference implementation.
  const SipKey key = counting_key();
  std::uint8_t input[64];
  for (std::size_t i = 0; i < sizeof input; ++i) input[i] = static_cast<std::uint8_t>(i);
  const auto hash = [&](std::size_t length) { return siphash24(key, {input, length}); };
  CHECK(hash(0) == 0x726fdb47dd0e0e31u);
  CHECK(hash(1) == 0x74f839c593dc67fdu);
  CHECK(hash(2) == 0x0d6c8009d9a94f5au);
  CHECK(hash(3) == 0x85676696d7fb7e2du);
  CHECK(hash(15) == 0xa129ca6149be45e5u);
  CHECK(hash(63) == 0x958a324ceb064572u);
}

TEST_CASE("a change of a log is written as lcm-gen writes it and comes back") {
  rt::ParameterChange change;
  REQUIRE(rt::make_change("odometry.scale", 1.02, 123, change) == Status::ok);
  const Bytes bytes = exact([&](auto out, auto& size) { return encode(change, 9, out, size); });
  CHECK(bytes == generated_bytes(parameter_t{123, 9, "odometry.scale", 1.02}));
  rt::ParameterChange back;
  std::int64_t seq = 0;
  REQUIRE(decode(bytes, back, seq) == Status::ok);
  CHECK(seq == 9);
  CHECK(rt::name_of(back) == "odometry.scale");
  CHECK(back.value == 1.02);
  CHECK(back.stamp_ns == 123);
  const Bytes long_name = generated_bytes(parameter_t{1, 1, std::string(48, 'x'), 1});
  CHECK(decode(long_name, back, seq) == Status::malformed);
  CHECK(decode(generated_bytes(parameter_t{1, 1, "", 1}), back, seq) == Status::malformed);
  CHECK(rt::name_of(back) == "odometry.scale");
}

TEST_CASE("a request is written as lcm-gen writes it, and its tag covers every byte") {
  const SipKey key = counting_key();
  const Bytes open = request_bytes(some_request(), nullptr);
  CHECK(open == generated_bytes(set_parameter_t{1, 2, 3, 4, "drive.max_speed_m_s", 0.25, 0}));
  SetParameter back;
  REQUIRE(decode(open, nullptr, back) == Status::ok);
  CHECK(back.counter == 4);
  CHECK(rt::name_of(back.change) == "drive.max_speed_m_s");
  CHECK(decode(open, &key, back) == Status::disconnected);

  const Bytes tagged = request_bytes(some_request(), &key);
  CHECK(tagged.size() == open.size());
  REQUIRE(decode(tagged, &key, back) == Status::ok);
  CHECK(back.change.value == 0.25);
  SipKey other = key;
  other[15] ^= 1u;
  CHECK(decode(tagged, &other, back) == Status::disconnected);
  for (std::size_t bit = 0; bit < 8 * tagged.size(); ++bit) {
    Bytes spoiled = tagged;
    spoiled[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    INFO("bit " << bit);
    REQUIRE(decode(spoiled, &key, back) != Status::ok);
  }
  const std::string longest(rt::kMaxParameterName, 'x');
  REQUIRE(decode(generated_bytes(set_parameter_t{1, 2, 3, 5, longest, 1, 0}), nullptr, back) == Status::ok);
  CHECK(rt::name_of(back.change) == longest);
  // Malformed before its tag is looked at.
  const Bytes long_name = generated_bytes(set_parameter_t{1, 2, 3, 6, longest + "x", 1, 0});
  CHECK(decode(long_name, &key, back) == Status::malformed);
  CHECK(back.counter == 5);
}

TEST_CASE("the parameters in force are written as lcm-gen writes them and come back") {
  ParametersMessage message;
  message.utime = 5;
  message.session = 6;
  message.counter = 7;
  message.scene = "hall";
  message.remote = true;
  message.parameters = {{"a", "m", 1, 0, 2}, {"b", "", -1, -2, 0}};
  message.answers = {{11, 12, 0}, {13, 14, 4}, {15, 16, 3}};
  parameters_t twin{};
  twin.utime = 5;
  twin.session = 6;
  twin.counter = 7;
  twin.scene = "hall";
  twin.remote = 1;
  twin.n = 2;
  twin.name = {"a", "b"};
  twin.unit = {"m", ""};
  twin.value = {1, -1};
  twin.low = {0, -2};
  twin.high = {2, 0};
  twin.answers = 3;
  twin.sender = {11, 13, 15};
  twin.asked = {12, 14, 16};
  twin.status = {0, 4, 3};
  const Bytes bytes = exact([&](auto out, auto& size) { return encode(message, out, size); });
  CHECK(bytes == generated_bytes(twin));
  ParametersMessage back;
  REQUIRE(decode(bytes, back) == Status::ok);
  CHECK(back.scene == "hall");
  CHECK(back.remote);
  CHECK_FALSE(back.keyed);
  CHECK(back.parameters[1].low == -2);
  CHECK(back.answers[2].status == 3);
}

TEST_CASE("cut and damaged parameter messages are refused or decoded without harm") {
  std::mt19937_64 random(11);
  rt::ParameterChange change;
  REQUIRE(rt::make_change("map.max_range_m", 20, 3, change) == Status::ok);
  ParametersMessage parameters;
  parameters.scene = "s";
  parameters.parameters = {{"a", "m", 1, 0, 2}};
  parameters.answers = {{1, 2, 3}};
  const Bytes all[] = {exact([&](auto out, auto& size) { return encode(change, 1, out, size); }),
                       request_bytes(some_request(), nullptr),
                       exact([&](auto out, auto& size) { return encode(parameters, out, size); })};
  const auto read = [](std::span<const std::uint8_t> bytes) {
    rt::ParameterChange one;
    std::int64_t seq = 0;
    SetParameter request;
    ParametersMessage message;
    int good = decode(bytes, one, seq) == Status::ok ? 1 : 0;
    good += decode(bytes, nullptr, request) == Status::ok ? 1 : 0;
    return good + (decode(bytes, message) == Status::ok ? 1 : 0);
  };
  for (const Bytes& whole : all) {
    CHECK(read(whole) == 1);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      REQUIRE(read(cut) == 0);
    }
    Bytes longer = whole;
    longer.push_back(0);
    CHECK(read(longer) == 0);
    for (int round = 0; round < 20000; ++round) {
      Bytes spoiled = whole;
      for (int i = 0; i < 3; ++i)
        spoiled[static_cast<std::size_t>(random() % spoiled.size())] = static_cast<std::uint8_t>(random());
      static_cast<void>(read(spoiled));  // under the sanitizers
    }
  }
}
