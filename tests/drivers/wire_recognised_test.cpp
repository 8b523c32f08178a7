// SPDX-License-Identifier: BSD-3-Clause
// recognised_t against lcm-gen's code: same bytes, every bit back, nothing taken that is damaged.
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "drivers/wire.hpp"
#include "sortie/recognised_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

// Every scalar its own bits, so that two that change places are seen.
rt::RecognisedPlace any_recognised(std::mt19937_64& random) {
  rt::RecognisedPlace place;
  const auto number = [&] { return std::ldexp(static_cast<double>(random() >> 11), -40); };
  place.stamp_ns = static_cast<rt::Nanoseconds>(random());
  place.verdict = static_cast<std::uint8_t>(random());
  for (double& v : place.p_known_odom_m) v = number();
  for (double& v : place.q_known_odom) v = number();
  for (double& v : place.covariance) v = number();
  place.speaking = static_cast<std::uint32_t>(random());
  place.pairs = static_cast<std::uint32_t>(random());
  place.agree = static_cast<std::uint32_t>(random());
  place.rival = static_cast<std::uint32_t>(random());
  place.rms_m = number();
  place.spread_m = number();
  place.proved = random() % 2 == 0;
  place.share = number();
  place.crossed = number();
  return place;
}

recognised_t twin_of(const rt::RecognisedPlace& place, std::int64_t seq) {
  recognised_t twin{};
  twin.stamp_ns = place.stamp_ns;
  twin.seq = seq;
  twin.verdict = static_cast<std::int8_t>(place.verdict);
  std::memcpy(twin.p_known_odom_m, place.p_known_odom_m, sizeof twin.p_known_odom_m);
  std::memcpy(twin.q_known_odom, place.q_known_odom, sizeof twin.q_known_odom);
  std::memcpy(twin.covariance, place.covariance, sizeof twin.covariance);
  twin.speaking = static_cast<std::int32_t>(place.speaking);
  twin.pairs = static_cast<std::int32_t>(place.pairs);
  twin.agree = static_cast<std::int32_t>(place.agree);
  twin.rival = static_cast<std::int32_t>(place.rival);
  twin.rms_m = place.rms_m;
  twin.spread_m = place.spread_m;
  twin.proved = place.proved ? 1 : 0;
  twin.share = place.share;
  twin.crossed = place.crossed;
  return twin;
}

test::Bytes recognised_bytes(const rt::RecognisedPlace& place, std::int64_t seq) {
  return test::exact([&](auto out, auto& size) { return encode(place, seq, out, size); });
}

}  // namespace

TEST_CASE("a recognised place is written as lcm-gen writes it and comes back bit for bit") {
  std::mt19937_64 random(27);
  for (std::int64_t round = 0; round < 50; ++round) {
    INFO("seed 27, round " << round);
    const rt::RecognisedPlace place = any_recognised(random);
    const test::Bytes bytes = recognised_bytes(place, round);
    REQUIRE(bytes.size() == kRecognisedBytes);
    REQUIRE((bytes == test::generated_bytes(twin_of(place, round))));
    rt::RecognisedPlace back;
    std::int64_t seq = -1;
    REQUIRE(decode(bytes, back, seq) == Status::ok);
    REQUIRE(seq == round);
    REQUIRE((recognised_bytes(back, seq) == bytes));
    test::Bytes cut = bytes;
    cut.pop_back();
    REQUIRE(decode(cut, back, seq) == Status::malformed);
  }
}
