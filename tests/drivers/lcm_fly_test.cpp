// SPDX-License-Identifier: BSD-3-Clause
// Requests to a pilot against lcm-gen's code, their tag, and damaged bytes.
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "drivers/wire_requests.hpp"
#include "sortie/fly_request_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

Bytes fly_bytes_of(const FlyRequestMessage& request, const SipKey* key) {
  return exact([&](auto out, auto& size) { return encode(request, key, out, size); });
}

const FlyRequestMessage kSomeFlight{{0, 4, {0.25, -0.5, 1.5}, 3.0, 2}, 1, 2, 3};

}  // namespace

TEST_CASE("a request to fly is written as lcm-gen writes it, and every field comes back") {
  const Bytes bytes = fly_bytes_of(kSomeFlight, nullptr);
  CHECK(bytes.size() == kFlyRequestBytes);
  CHECK(bytes == generated_bytes(fly_request_t{1, 2, 3, 4, 0.25, -0.5, 1.5, 3.0, 2, 0}));
  std::mt19937_64 random(17);
  const SipKey key{1, 2, 3};
  for (int i = 0; i < 1000; ++i) {
    FlyRequestMessage request;
    request.utime = static_cast<std::int64_t>(random());
    request.session = static_cast<std::int64_t>(random());
    request.sender = static_cast<std::int64_t>(random());
    request.counter = static_cast<std::int64_t>(random());
    double* const p_m = request.p_world_m;
    for (double* number : {p_m, p_m + 1, p_m + 2, &request.yaw_rad}) {
      const std::uint64_t bits = random();
      std::memcpy(number, &bits, 8);  // any bits, NaNs among them: judged by whoever takes it
    }
    request.mode = static_cast<std::uint32_t>(random());
    const SipKey* const used = i % 2 == 0 ? &key : nullptr;
    const Bytes sent = fly_bytes_of(request, used);
    FlyRequestMessage back;
    REQUIRE(decode(sent, used, back) == Status::ok);
    REQUIRE(fly_bytes_of(back, used) == sent);
    REQUIRE(back.counter == request.counter);
    REQUIRE(back.mode == request.mode);
  }
}

TEST_CASE("the tag of a request to fly covers every bit, and any other length is malformed") {
  const SipKey key{9, 8, 7};
  const Bytes tagged = fly_bytes_of(kSomeFlight, &key);
  FlyRequestMessage back;
  back.counter = 99;
  CHECK(decode(fly_bytes_of(kSomeFlight, nullptr), &key, back) == Status::disconnected);
  for (std::size_t bit = 0; bit < 8 * tagged.size(); ++bit) {
    Bytes spoiled = tagged;
    spoiled[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    INFO("bit " << bit);
    REQUIRE(decode(spoiled, &key, back) != Status::ok);
  }
  const Bytes whole = fly_bytes_of(kSomeFlight, nullptr);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    REQUIRE(decode(cut, nullptr, back) != Status::ok);
  }
  CHECK(back.counter == 99);
}
