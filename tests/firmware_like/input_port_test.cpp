// SPDX-License-Identifier: BSD-3-Clause
// The gate between outside and executive: what a job can take stands in the log, whoever is faster.
#include "firmware_like/runtime/input_port.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::testing;

namespace {

class CountingSink final : public SampleSink {
 public:
  void sample(const std::string&, rt::Nanoseconds, std::span<const std::uint8_t>) override { ++samples; }
  std::int64_t samples{};
};

struct Gate {
  explicit Gate(std::uint32_t capacity) : ring(capacity), batch(capacity) { port.set_sink(&sink); }

  std::vector<Reading> ring;
  std::vector<Reading> batch;
  rt::Stream<Reading> stream{"readings",   0,
                             ring.data(),  static_cast<std::uint32_t>(ring.size()),
                             batch.data(), static_cast<std::uint32_t>(batch.size())};
  InputPort<Reading> port{"SORTIE_CUSTOM_readings", stream};
  CountingSink sink;
};

}  // namespace

TEST_CASE("what does not fit is refused, counted, and not in the log") {
  Gate gate(4);
  for (std::uint32_t i = 0; i < 6; ++i)
    CHECK(gate.port.push({i, i}, i) == (i < 4 ? Status::ok : Status::full));
  CHECK(gate.sink.samples == 4);
  CHECK(gate.port.admitted() == 4);
  CHECK(gate.stream.refused() == 2);
}

TEST_CASE("a consumer that makes room while a sample is being refused gets none that the log lacks") {
  // The ring is nearly always full here, and room appears at any moment of a push.
  Gate gate(2);
  std::atomic<bool> stop{false};
  std::uint64_t taken = 0;
  std::thread consumer([&] {
    rt::StreamRange range;
    for (rt::Tick tick = 0; !stop.load(std::memory_order_relaxed); ++tick) {
      gate.stream.latch(tick, 1, range);
      taken += range.count;
    }
  });
  std::uint32_t pushed = 0;
  const auto has_enough = [&] { return gate.port.admitted() >= 2'000 && gate.stream.refused() > 100; };
  for (; !has_enough() && pushed < 4'000'000; ++pushed) {
    static_cast<void>(gate.port.push({pushed, pushed}, pushed));
    if (pushed % 256 == 0) std::this_thread::yield();  // where both share a core
  }
  stop.store(true);
  consumer.join();
  CHECK(gate.stream.refused() > 100);
  CHECK(gate.port.admitted() + gate.stream.refused() == pushed);
  CHECK(taken + gate.stream.waiting() == static_cast<std::uint64_t>(gate.port.admitted()));
  CHECK(gate.sink.samples == gate.port.admitted());
}

TEST_CASE("what no log could hold is refused and counted, be a log kept or not") {
  for (const bool recorded : {true, false}) {
    CountingSink sink;
    std::vector<rt::SslReturns> ring(4);
    std::vector<rt::SslReturns> batch(4);
    rt::Stream<rt::SslReturns> stream("returns", 0, ring.data(), 4, batch.data(), 4);
    InputPort<rt::SslReturns> port("SSL", stream);
    if (recorded) port.set_sink(&sink);
    rt::SslReturns returns;
    returns.rays = 2;
    CHECK(port.push(returns, 1) == Status::ok);
    returns.direction[1] = rt::kSslDirections;  // a reader of the log would not take it
    CHECK(port.push(returns, 2) == Status::out_of_range);
    returns.rays = rt::kSslMaxRays + 1;
    CHECK(port.push(returns, 3) == Status::out_of_range);
    CHECK(sink.samples == (recorded ? 1 : 0));
    CHECK(port.admitted() == 1);
    CHECK(stream.waiting() == 1);
    CHECK(stream.refused() == 2);
  }
  std::vector<rt::ParameterChange> ring(4);
  std::vector<rt::ParameterChange> batch(4);
  rt::Stream<rt::ParameterChange> changes("changes", 0, ring.data(), 4, batch.data(), 4);
  InputPort<rt::ParameterChange> port("PARAM", changes);
  CHECK(port.push({}, 1) == Status::out_of_range);  // it has no name
  CHECK(changes.waiting() == 0);
}
