// SPDX-License-Identifier: BSD-3-Clause
// Requests to the drive against lcm-gen's code, their tag, and damaged bytes.
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <random>

#include "drivers/wire_requests.hpp"
#include "sortie/drive_request_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

SipKey some_key() {
  SipKey key{};
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(3 * i + 1);
  return key;
}

Bytes bytes_of(const DriveRequestMessage& request, const SipKey* key) {
  return exact([&](auto out, auto& size) { return encode(request, key, out, size); });
}

const DriveRequestMessage kSome{{0, 4, 0.25, -0.5, 1, -1, 1, 6.5, -1.25}, 1, 2, 3};

}  // namespace

TEST_CASE("a request to the drive is written as lcm-gen writes it, and every field comes back") {
  const Bytes bytes = bytes_of(kSome, nullptr);
  CHECK(bytes.size() == kDriveRequestBytes);
  CHECK(bytes == generated_bytes(drive_request_t{1, 2, 3, 4, 0.25, -0.5, 1, -1, 1, 6.5, -1.25, 0}));
  std::mt19937_64 random(13);
  const SipKey key = some_key();
  for (int i = 0; i < 2000; ++i) {
    DriveRequestMessage request;
    request.utime = static_cast<std::int64_t>(random());
    request.session = static_cast<std::int64_t>(random());
    request.sender = static_cast<std::int64_t>(random());
    request.counter = static_cast<std::int64_t>(random());
    const std::uint64_t bits[] = {random(), random(), random(), random()};
    std::memcpy(&request.speed_m_s, &bits[0], 8);  // any bits, NaNs among them: judged by whoever takes it
    std::memcpy(&request.turn_rad_s, &bits[1], 8);
    std::memcpy(&request.goal_x_m, &bits[2], 8);
    std::memcpy(&request.goal_y_m, &bits[3], 8);
    request.mode = static_cast<std::uint32_t>(random());
    request.posture = static_cast<std::int32_t>(random());
    request.flags = static_cast<std::uint32_t>(random());
    const Bytes sent = bytes_of(request, i % 2 == 0 ? &key : nullptr);
    DriveRequestMessage back;
    REQUIRE(decode(sent, i % 2 == 0 ? &key : nullptr, back) == Status::ok);
    REQUIRE(bytes_of(back, i % 2 == 0 ? &key : nullptr) == sent);
    REQUIRE(back.counter == request.counter);
    REQUIRE(back.flags == request.flags);
  }
}

TEST_CASE("the tag of a request to the drive covers every bit, and belongs to one secret") {
  const SipKey key = some_key();
  const Bytes tagged = bytes_of(kSome, &key);
  DriveRequestMessage back;
  back.counter = 99;
  CHECK(decode(bytes_of(kSome, nullptr), &key, back) == Status::disconnected);
  SipKey other = key;
  other[0] ^= 1u;
  CHECK(decode(tagged, &other, back) == Status::disconnected);
  for (std::size_t bit = 0; bit < 8 * tagged.size(); ++bit) {
    Bytes spoiled = tagged;
    spoiled[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    INFO("bit " << bit);
    REQUIRE(decode(spoiled, &key, back) != Status::ok);
  }
  CHECK(back.counter == 99);
}

TEST_CASE("a request to the drive of any other length is malformed, of another type not one at all") {
  const Bytes whole = bytes_of(kSome, nullptr);
  DriveRequestMessage back;
  for (std::size_t length = 0; length < whole.size(); ++length)
    REQUIRE(decode({whole.data(), length}, nullptr, back) == Status::malformed);
  Bytes longer = whole;
  longer.push_back(0);
  CHECK(decode(longer, nullptr, back) == Status::malformed);
  Bytes foreign = whole;
  foreign[0] ^= 0x80u;
  CHECK(decode(foreign, nullptr, back) == Status::bad_checksum);
}
