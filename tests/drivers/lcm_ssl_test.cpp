// SPDX-License-Identifier: BSD-3-Clause
// Messages of the solid-state lidar against lcm-gen's code, damaged bytes, and the link in memory.
#include <catch2/catch.hpp>
#include <random>

#include "drivers/ssl_port.hpp"
#include "drivers/wire_ssl.hpp"
#include "rt/fields.hpp"
#include "sortie/ssl_command_t.hpp"
#include "sortie/ssl_returns_t.hpp"
#include "tests/drivers/message_bytes.hpp"

namespace sortie::drivers {
namespace {

rt::SslReturns some_returns(std::uint32_t rays, std::mt19937_64& random) {
  rt::SslReturns returns;
  returns.stamp_ns = static_cast<std::int64_t>(random());
  returns.number = static_cast<std::uint32_t>(random());
  returns.rays = rays;
  for (std::uint32_t i = 0; i < rays; ++i) {
    returns.direction[i] = static_cast<std::uint16_t>(random() % rt::kSslDirections);
    returns.range_mm[i] = static_cast<std::uint16_t>(random());
    returns.age_10us[i] = static_cast<std::uint16_t>(random());
  }
  return returns;
}

test::Bytes ssl_bytes(const rt::SslReturns& returns, std::int64_t seq) {
  return test::exact([&](auto out, auto& size) { return encode(returns, seq, out, size); });
}

template <class Sample>
bool equal_fields(const Sample& a, const Sample& b) {
  std::uint8_t left[rt::canonical_size<Sample>()];
  std::uint8_t right[rt::canonical_size<Sample>()];
  rt::encode_canonical(a, left);
  rt::encode_canonical(b, right);
  return std::equal(std::begin(left), std::end(left), std::begin(right));
}

}  // namespace

TEST_CASE("a list of rays and a frame of ranges are written as lcm-gen writes them, and come back") {
  std::mt19937_64 random(17);
  for (const std::uint32_t rays : {0u, 1u, 200u, rt::kSslMaxRays}) {
    const rt::SslReturns returns = some_returns(rays, random);
    ssl_returns_t twin{};
    twin.stamp_ns = returns.stamp_ns;
    twin.seq = 42;
    twin.number = static_cast<std::int32_t>(returns.number);
    twin.n = static_cast<std::int32_t>(rays);
    ssl_command_t asked{};
    rt::SslCommand command;
    command.stamp_ns = asked.stamp_ns = 7;
    command.number = 9;
    asked.number = 9;
    asked.seq = -1;
    command.rays = rays;
    asked.n = twin.n;
    for (std::uint32_t i = 0; i < rays; ++i) {
      command.direction[i] = returns.direction[i];
      asked.direction.push_back(static_cast<std::int16_t>(returns.direction[i]));
      twin.direction.push_back(static_cast<std::int16_t>(returns.direction[i]));
      twin.range_mm.push_back(static_cast<std::int16_t>(returns.range_mm[i]));
      twin.age_10us.push_back(static_cast<std::int16_t>(returns.age_10us[i]));
    }
    const test::Bytes bytes = ssl_bytes(returns, 42);
    CHECK(bytes == test::generated_bytes(twin));
    CHECK(bytes.size() <= kSslReturnsBytes);
    rt::SslReturns back;
    std::int64_t seq = 0;
    REQUIRE(decode(bytes, back, seq) == Status::ok);
    CHECK(seq == 42);
    CHECK(equal_fields(back, returns));
    const test::Bytes list =
        test::exact([&](auto out, auto& size) { return encode(command, -1, out, size); });
    CHECK(list == test::generated_bytes(asked));
    CHECK(list.size() <= kSslCommandBytes);
    rt::SslCommand command_back;
    REQUIRE(decode(list, command_back, seq) == Status::ok);
    CHECK(seq == -1);
    CHECK(equal_fields(command_back, command));
    CHECK(decode(list, back, seq) == Status::bad_checksum);
  }
}

TEST_CASE("a frame of ranges that is cut, longer, too large or aims beside the grid changes nothing") {
  std::mt19937_64 random(18);
  const rt::SslReturns returns = some_returns(50, random);
  const test::Bytes bytes = ssl_bytes(returns, 1);
  const rt::SslReturns untouched = some_returns(3, random);
  rt::SslReturns back = untouched;
  std::int64_t seq = 77;
  const auto refused = [&](const test::Bytes& message) {
    const Status status = decode(message, back, seq);
    return status != Status::ok && equal_fields(back, untouched) && seq == 77;
  };
  for (std::size_t size = 0; size < bytes.size(); ++size)
    REQUIRE(refused(test::Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))));
  test::Bytes longer = bytes;
  longer.push_back(0);
  CHECK(refused(longer));
  test::Bytes many = bytes;
  many[28] = 0x7f;  // of the count, big endian
  CHECK(refused(many));
  many[28] = 0xff;
  CHECK(refused(many));
  test::Bytes beside = bytes;
  beside[32] = 0x4b;  // direction 19200
  beside[33] = 0x00;
  CHECK(refused(beside));
  // More rays than a frame has, with all their bytes there.
  test::Bytes crowd(bytes.begin(), bytes.begin() + 32);
  crowd[30] = 0x01;
  crowd[31] = 0x01;
  crowd.resize(32 + 6 * 257);
  CHECK(refused(crowd));
  rt::SslReturns large = returns;
  large.rays = 257;
  std::size_t size = 1;
  test::Bytes room(4096);
  CHECK(encode(large, 1, room, size) == Status::out_of_range);
  CHECK(size == 0);
}

TEST_CASE("the link to a solid-state lidar keeps order, refuses what cannot be fired, and is full at four") {
  SslStub link;
  rt::SslReturns returns;
  rt::SslCommand command;
  CHECK(link.receive(returns) == Status::empty);
  CHECK(link.take(command) == Status::empty);
  command.rays = rt::kSslMaxRays + 1;
  CHECK(link.send(command) == Status::out_of_range);
  command.rays = 2;
  command.direction[1] = 0xffff;
  CHECK(link.send(command) == Status::out_of_range);
  command.direction[1] = rt::kSslDirections - 1;
  for (std::uint32_t i = 0; i < 4; ++i) {
    command.number = returns.number = i;
    CHECK(link.send(command) == Status::ok);
    CHECK(link.deliver(returns) == Status::ok);
  }
  CHECK(link.send(command) == Status::full);
  CHECK(link.deliver(returns) == Status::full);
  for (std::uint32_t i = 0; i < 4; ++i) {
    REQUIRE(link.take(command) == Status::ok);
    CHECK(command.number == i);
    REQUIRE(link.receive(returns) == Status::ok);
    CHECK(returns.number == i);
  }
}

}  // namespace sortie::drivers
