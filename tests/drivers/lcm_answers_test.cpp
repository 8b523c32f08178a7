// SPDX-License-Identifier: BSD-3-Clause
// Answers to requests against lcm-gen's code, their tag, and damaged bytes.
#include <catch2/catch.hpp>
#include <random>

#include "drivers/wire_requests.hpp"
#include "sortie/request_answers_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

constexpr SipKey kKey{9, 8, 7, 6, 5, 4, 3, 2, 1};

AnswersMessage some_answers() {
  AnswersMessage message;
  message.utime = 1;
  message.session = 2;
  message.robot = "otter";
  message.task = "drive";
  message.keyed = true;
  message.counter = 3;
  message.answers = {{4, 5, 0}, {6, 7, 6}};
  message.state = {{"stop", 2.0}, {"speed_m_s", 0.25}, {"source", 3.0}};
  return message;
}

Bytes bytes_of(const AnswersMessage& message, const SipKey* key) {
  return exact([&](auto out, auto& size) { return encode(message, key, out, size); });
}

}  // namespace

TEST_CASE("answers to requests are written as lcm-gen writes them, and every field comes back") {
  request_answers_t twin{};
  twin.utime = 1;
  twin.session = 2;
  twin.robot = "otter";
  twin.task = "drive";
  twin.keyed = 1;
  twin.counter = 3;
  twin.answers = 2;
  twin.sender = {4, 6};
  twin.asked = {5, 7};
  twin.status = {0, 6};
  twin.n = 3;
  twin.name = {"stop", "speed_m_s", "source"};
  twin.value = {2.0, 0.25, 3.0};
  CHECK(bytes_of(some_answers(), nullptr) == generated_bytes(twin));
  AnswersMessage back;
  REQUIRE(decode(bytes_of(some_answers(), &kKey), &kKey, back) == Status::ok);
  CHECK(back.robot == "otter");
  CHECK(back.task == "drive");
  CHECK(back.keyed);
  CHECK(back.session == 2);
  CHECK(back.answers[1].counter == 7);
  CHECK(back.answers[1].status == 6);
  CHECK(back.state[1].name == "speed_m_s");
  CHECK(back.state[2].value == 3.0);
}

TEST_CASE("the tag of answers covers every bit, state and all, and what is not whole changes nothing") {
  const Bytes tagged = bytes_of(some_answers(), &kKey);
  AnswersMessage back;
  back.counter = 99;
  CHECK(decode(bytes_of(some_answers(), nullptr), &kKey, back) == Status::disconnected);
  for (std::size_t bit = 0; bit < 8 * tagged.size(); ++bit) {
    Bytes spoiled = tagged;
    spoiled[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    INFO("bit " << bit);
    REQUIRE(decode(spoiled, &kKey, back) != Status::ok);
  }
  for (std::size_t length = 0; length < tagged.size(); ++length)
    REQUIRE(decode({tagged.data(), length}, &kKey, back) != Status::ok);
  Bytes longer = tagged;
  longer.push_back(0);
  CHECK(decode(longer, nullptr, back) == Status::malformed);
  CHECK(back.counter == 99);
  const unsigned seed = 21;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 20'000; ++round) {
    Bytes spoiled = tagged;
    for (int i = 0; i < 3; ++i) spoiled[random() % spoiled.size()] = static_cast<std::uint8_t>(random());
    static_cast<void>(decode(spoiled, nullptr, back));  // under the sanitizers
  }
}
