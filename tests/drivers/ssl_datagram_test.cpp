// SPDX-License-Identifier: BSD-3-Clause
// Lists of rays and their answers in datagrams: what belongs together arrives bit for bit, everything else is
// counted by its reason and changes nothing.
#include "drivers/ssl_datagram.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "rt/fields.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/drivers/scripted_peer.hpp"

namespace sortie::drivers {
namespace {

constexpr rt::Nanoseconds kRayPlantEpoch = 7'000'000'000;
constexpr rt::Nanoseconds kRayRunEpoch = 9'000'000'123;

rt::SslCommand numbered_rays(std::uint32_t number, std::uint32_t rays, rt::Nanoseconds stamp_ns) {
  rt::SslCommand command;
  command.stamp_ns = stamp_ns;
  command.number = number;
  command.rays = rays;
  for (std::uint32_t i = 0; i < rays; ++i)
    command.direction[i] = static_cast<std::uint16_t>((number * 977 + i * 31) % rt::kSslDirections);
  return command;
}

rt::SslReturns answer_to(const rt::SslCommand& command, rt::Nanoseconds stamp_ns) {
  rt::SslReturns returns;
  returns.stamp_ns = stamp_ns;
  returns.number = command.number;
  returns.rays = command.rays;
  for (std::uint32_t i = 0; i < command.rays; ++i) {
    returns.direction[i] = command.direction[i];
    returns.range_mm[i] = static_cast<std::uint16_t>(65535 - i);
    returns.age_10us[i] = static_cast<std::uint16_t>(command.rays - i);
  }
  return returns;
}

template <class Sample>
bool same_ray_bits(const Sample& a, const Sample& b) {
  std::uint8_t left[rt::canonical_size<Sample>()];
  std::uint8_t right[rt::canonical_size<Sample>()];
  rt::encode_canonical(a, left);
  rt::encode_canonical(b, right);
  return std::equal(std::begin(left), std::end(left), std::begin(right));
}

template <class Sample>
test::Datagram message_of_rays(const Sample& sample) {
  test::Datagram bytes(4096);
  std::size_t size = 0;
  REQUIRE(encode(sample, 0, bytes, size) == Status::ok);
  bytes.resize(size);
  return bytes;
}

// The runtime's end opposite a device written by hand. Its run began a second ago.
struct ScriptedDevice {
  ScriptedDevice()
      : port(test::free_port()), socket(port), epoch(rt::posix::monotonic_now() - 1'000'000'000) {
    head.purpose = 3;
    head.from = test::kPlantSession;
    head.to = test::kRuntimeSession;
    std::string problem;
    REQUIRE(driver.open(test::runtime_end(port), epoch, problem) == Status::ok);
    driver.poll();
    REQUIRE_FALSE(socket.take(runtime).empty());
    head.kind = 1;
    post(test::Datagram{});
    head.kind = 2;
    REQUIRE(driver.link().has_peer());
  }
  void post(const test::Datagram& payload) {
    ++head.number;
    socket.send(runtime, test::scripted(head, payload));
    driver.poll();
  }
  void post(const rt::SslReturns& returns) { post(message_of_rays(returns)); }
  rt::Nanoseconds now() const { return rt::posix::monotonic_now(); }
  // The oldest frame of the driver must be this one.
  void expect(rt::SslReturns sent) {
    rt::SslReturns got;
    REQUIRE(driver.receive(got) == Status::ok);
    sent.stamp_ns -= epoch;
    REQUIRE(same_ray_bits(got, sent));
  }
  void expect_nothing() {
    rt::SslReturns got;
    REQUIRE(driver.receive(got) == Status::empty);
  }
  std::uint16_t port;
  test::LoopbackSocket socket;
  rt::Nanoseconds epoch;
  std::uint16_t runtime{};
  test::ScriptedHead head;
  SslDatagram driver;
};

std::uint64_t ray_refusals(const SslDatagramCounters& c) {
  return c.malformed + c.unasked + c.repeated + c.overtaken + c.mismatched + c.out_of_time + c.overrun;
}

}  // namespace

TEST_CASE("lists of rays and their answers arrive bit for bit, each on the other process's clock") {
  const std::uint16_t port = test::free_port();
  const rt::Nanoseconds now = rt::posix::monotonic_now();
  SslDatagramDevice far_end;
  SslDatagram driver;
  SslStub device;
  std::string problem;
  const rt::Nanoseconds plant_zero = now - kRayPlantEpoch;
  const rt::Nanoseconds run_zero = now - kRayRunEpoch;
  REQUIRE(far_end.open(test::plant_end(port), plant_zero, problem) == Status::ok);
  REQUIRE(driver.open(test::runtime_end(port), run_zero, problem) == Status::ok);
  CHECK(driver.send(numbered_rays(1, 3, 0)) == Status::disconnected);  // nobody has been heard yet
  CHECK(driver.counters().unsent == 1);
  rt::SslCommand too_long = numbered_rays(1, rt::kSslMaxRays, 0);
  ++too_long.rays;
  CHECK(driver.send(too_long) == Status::out_of_range);
  const auto exchange = [&] {
    driver.poll();
    far_end.deliver(device);
    far_end.collect(device);
    driver.poll();
  };
  exchange();
  std::uint32_t number = 1;
  std::uint64_t heap_calls = 0;
  for (const std::uint32_t rays : {0u, 1u, 200u, rt::kSslMaxRays}) {
    rt::SslCommand command = numbered_rays(++number, rays, rt::posix::monotonic_now() - run_zero);
    rt::SslCommand taken;
    rt::SslReturns got;
    REQUIRE(driver.send(command) == Status::ok);
    far_end.deliver(device);
    REQUIRE(device.take(taken) == Status::ok);
    command.stamp_ns += run_zero - plant_zero;
    CHECK(same_ray_bits(taken, command));
    rt::SslReturns answer = answer_to(taken, rt::posix::monotonic_now() - plant_zero);
    REQUIRE(device.deliver(answer) == Status::ok);
    {
      const rt::posix::HeapTrapScope scope;
      exchange();
      heap_calls += scope.calls();
    }
    REQUIRE(driver.receive(got) == Status::ok);
    answer.stamp_ns += plant_zero - run_zero;
    CHECK(same_ray_bits(got, answer));
  }
  CHECK(heap_calls == 0);
  CHECK(driver.counters().frames == 4);
  CHECK(far_end.counters().commands == 4);
  CHECK(far_end.counters().frames == 4);
  CHECK(ray_refusals(driver.counters()) == 0);
}

TEST_CASE("an answer that is lost, late, double, foreign or of other rays harms nothing but its counter") {
  ScriptedDevice device;
  const SslDatagramCounters& seen = device.driver.counters();
  std::vector<rt::SslCommand> asked;
  for (std::uint32_t number = 1; number <= 6; ++number) {
    asked.push_back(numbered_rays(number, 200, 0));
    REQUIRE(device.driver.send(asked.back()) == Status::ok);
  }
  const auto answer = [&](std::uint32_t number) { return answer_to(asked[number - 1], device.now()); };
  device.post(answer_to(numbered_rays(7, 200, 0), device.now()));  // the next one, before it is asked for
  device.post(answer_to(numbered_rays(0x80000001u, 200, 0), device.now()));
  CHECK(seen.unasked == 2);
  rt::SslReturns first = answer(1);
  device.post(first);
  device.expect(first);
  device.post(first);  // the same frame in a datagram of its own
  CHECK(seen.repeated == 1);
  rt::SslReturns third = answer(3);  // that of 2 is lost, or late
  device.post(third);
  device.expect(third);
  device.post(answer(2));
  CHECK(seen.overtaken == 1);

  rt::SslReturns fewer = answer(4);
  --fewer.rays;
  device.post(fewer);
  rt::SslReturns others = answer(4);
  others.direction[199] = static_cast<std::uint16_t>((others.direction[199] + 1) % rt::kSslDirections);
  device.post(others);
  CHECK(seen.mismatched == 2);
  rt::SslReturns ahead = answer(4);
  ahead.stamp_ns += 1'000'000'000;
  device.post(ahead);
  rt::SslReturns behind = answer(4);
  behind.stamp_ns -= 1'100'000'000;
  device.post(behind);
  for (const rt::Nanoseconds end : {INT64_MIN, INT64_MAX}) {
    behind.stamp_ns = end;
    device.post(behind);
  }
  CHECK(seen.out_of_time == 4);
  device.expect_nothing();
  rt::SslReturns fourth = answer(4);  // after all of these, the true one still counts
  device.post(fourth);
  device.expect(fourth);
  CHECK(seen.frames == 3);

  // Commands further back than the driver remembers are no longer answered.
  for (std::uint32_t number = 7; number <= 6 + SslDatagram::kRemembered; ++number)
    REQUIRE(device.driver.send(numbered_rays(number, 5, 0)) == Status::ok);
  device.post(answer(6));
  CHECK(seen.unasked == 3);
  // Frames that nobody takes: the oldest stay.
  for (std::uint32_t number = 7; number <= 12; ++number)
    device.post(answer_to(numbered_rays(number, 5, 0), device.now()));
  CHECK(seen.overrun == 2);
  for (std::uint32_t number = 7; number <= 10; ++number) {
    rt::SslReturns got;
    REQUIRE(device.driver.receive(got) == Status::ok);
    CHECK(got.number == number);
  }
  device.expect_nothing();
}

TEST_CASE("no bytes that come over the link are taken for an answer, nor keep the true one away") {
  constexpr unsigned kSeed = 20;
  INFO("seed " << kSeed);
  std::mt19937_64 random(kSeed);
  ScriptedDevice device;
  const SslDatagramCounters& seen = device.driver.counters();
  const rt::SslCommand command = numbered_rays(5, 16, 0);
  REQUIRE(device.driver.send(command) == Status::ok);
  const rt::SslReturns whole = answer_to(command, device.now());
  const test::Datagram good = message_of_rays(whole);
  for (std::size_t size = 0; size < good.size(); ++size)
    device.post(test::Datagram(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
  test::Datagram longer = good;
  longer.push_back(0);
  device.post(longer);
  device.post(message_of_rays(command));  // of the other direction's type
  CHECK(seen.malformed == good.size() + 2);
  // Damage before the ranges: they alone may hold any bits.
  const std::size_t head = 8 + 8 + 8;
  std::uint64_t damaged = 0;
  for (int i = 0; i < 500; ++i) {
    test::Datagram bytes = good;
    const std::size_t place = head + static_cast<std::size_t>(random() % (8 + 2 * 16));
    const auto flip = static_cast<std::uint8_t>(1 + random() % 255);
    bytes[place] = static_cast<std::uint8_t>(bytes[place] ^ flip);
    device.post(bytes);
    ++damaged;
  }
  CHECK(ray_refusals(seen) == good.size() + 2 + damaged);
  CHECK(seen.frames == 0);
  device.expect_nothing();
  rt::SslReturns fresh = answer_to(command, device.now());
  device.post(fresh);
  device.expect(fresh);
}

TEST_CASE("a device fires a list of rays once, in order, and only for a pose that is not past") {
  const std::uint16_t port = test::free_port();
  SslDatagramDevice far_end;
  SslStub device;
  std::string problem;
  REQUIRE(far_end.open(test::plant_end(port), 0, problem) == Status::ok);
  const test::LoopbackSocket runtime;
  test::ScriptedHead head;
  head.purpose = 3;
  const auto greet = [&](std::uint64_t session) {
    head.kind = 1;
    head.from = session;
    head.to = 0;
    ++head.number;
    runtime.send(port, test::scripted(head, {}));
    head.kind = 2;
    head.to = test::kPlantSession;
  };
  const auto post = [&](const test::Datagram& payload) {
    ++head.number;
    runtime.send(port, test::scripted(head, payload));
    far_end.deliver(device);
  };
  const auto command = [&](std::uint32_t number, rt::Nanoseconds late_ns) {
    post(message_of_rays(numbered_rays(number, 10, rt::posix::monotonic_now() - late_ns)));
  };
  const SslDeviceCounters& seen = far_end.counters();
  rt::SslCommand taken;
  greet(test::kRuntimeSession);
  command(4, 0);
  REQUIRE(device.take(taken) == Status::ok);
  CHECK(taken.number == 4);
  command(4, 0);
  command(3, 0);
  CHECK(seen.repeated == 2);
  command(5, 300'000'000);
  command(5, -2'000'000'000);
  CHECK(seen.out_of_time == 2);
  post(test::Datagram(40, 0xff));
  // A direction that there is not: the encoder refuses it, so the last one is written over.
  test::Datagram wild = message_of_rays(numbered_rays(5, 10, rt::posix::monotonic_now()));
  wild[wild.size() - 2] = static_cast<std::uint8_t>(rt::kSslDirections >> 8);
  wild[wild.size() - 1] = static_cast<std::uint8_t>(rt::kSslDirections & 0xff);
  post(wild);
  post(message_of_rays(answer_to(taken, 0)));
  CHECK(seen.malformed == 3);
  CHECK(device.take(taken) == Status::empty);
  for (std::uint32_t number = 5; number <= 10; ++number) command(number, 0);
  CHECK(seen.commands == 1 + 4);  // the link in memory holds four
  CHECK(seen.refused == 2);
  for (std::uint32_t number = 5; number <= 8; ++number) {
    REQUIRE(device.take(taken) == Status::ok);
    CHECK(taken.number == number);
  }
  // Another life of the runtime counts from the beginning.
  head.kind = 3;
  post({});
  greet(test::kRuntimeSession + 1);
  command(1, 0);
  REQUIRE(device.take(taken) == Status::ok);
  CHECK(taken.number == 1);
}

}  // namespace sortie::drivers
