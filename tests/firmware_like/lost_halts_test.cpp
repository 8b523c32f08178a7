// SPDX-License-Identifier: BSD-3-Clause
// Thousands of halts, each sent once, among senders that race, forge, play again, hold back and damage, into
// a process that is stopped now and then: none is lost, and none is undone by anything sent before it.
#include <catch2/catch.hpp>
#include <random>

#include "tests/firmware_like/lone_robot.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::testing;

namespace {

constexpr rt::Nanoseconds kOneSecond = rt::kNanosecondsPerSecond;
constexpr rt::Nanoseconds kStep = 5 * rt::kNanosecondsPerMillisecond;
constexpr rt::Nanoseconds kUtc = 1'790'000'000 * kOneSecond;
constexpr int kRounds = 3000;
constexpr drivers::SipKey kSecret{4, 5, 6};

template <class Robot>
class Network {
 public:
  using Message = typename Robot::Message;
  using Bytes = std::vector<std::uint8_t>;
  explicit Network(unsigned seed) : random_(seed) {}

  std::int64_t below(std::int64_t most) {
    return static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(most));
  }
  bool one_in(std::int64_t of) { return below(of) == 0; }

  Bytes signed_bytes(Message message, std::int64_t counter, std::int64_t sender) {
    message.counter = counter;
    message.sender = sender;
    message.utime = (kUtc + now_ns) / 1000;
    return bytes_of(message, &kSecret);
  }
  void deliver(const Bytes& bytes, rt::Nanoseconds waited_ns = 0) {
    robot.lone.desk.take(bytes,
                         {&kSecret, 0, now_ns, {kUtc + now_ns - waited_ns, kUtc + now_ns, 2 * kOneSecond}});
  }
  // A counter as somebody knows it who hears of it ten times a second.
  std::int64_t known() { return std::max<std::int64_t>(robot.newest() - below(20), 0); }

  // What friends without regard for each other, and enemies, send in one step.
  void others() {
    while (one_in(2)) {
      const Bytes bytes = signed_bytes(Robot::move(), known() + 1 + (one_in(4) ? below(2000) : 0), 11);
      deliver(bytes, one_in(5) ? below(12 * kOneSecond) : 0);
      remember(bytes);
    }
    if (one_in(20)) {  // more at once than a job takes
      for (int i = 0; i < 40; ++i) deliver(signed_bytes(Robot::move(), robot.newest() + 1 + i, 12));
    }
    if (one_in(3)) {  // without the secret
      Message forged = one_in(2) ? Robot::release() : Robot::move();
      forged.counter = one_in(2) ? known() + 1 : static_cast<std::int64_t>(random_() >> 1);
      forged.utime = (kUtc + now_ns) / 1000;
      deliver(bytes_of(forged, nullptr));
    }
    if (one_in(3) && !recorded_.empty())
      deliver(recorded_[static_cast<std::size_t>(below(static_cast<std::int64_t>(recorded_.size())))]);
    if (one_in(50)) deliver(signed_bytes(Robot::move(), robot.newest() + 2'000'000, 16));
    if (one_in(5)) {
      Bytes damaged = signed_bytes(one_in(2) ? Robot::stop() : Robot::release(), robot.newest() + 1, 13);
      damaged[static_cast<std::size_t>(below(static_cast<std::int64_t>(damaged.size())))] ^=
          static_cast<std::uint8_t>(1 + below(255));
      deliver(damaged);
    }
  }
  void job() {
    now_ns += rt::kNanosecondsPerMicrosecond;
    robot.lone.desk.hand_in(now_ns);
    robot.job(now_ns);
  }
  // One step of time; a process that is starved or stopped runs no job meanwhile.
  void step(bool quiet) {
    now_ns += one_in(200) ? below(12 * kOneSecond) : kStep;
    if (!quiet) others();
    if (quiet || !one_in(4)) job();
  }
  // A friend ends the halt. False: it cannot.
  bool set_free() {
    for (int i = 0; i < 2000 && robot.is_stopped(); ++i) {
      now_ns += kStep;
      const Bytes release = signed_bytes(Robot::release(), robot.newest() + 1 + 2000 * (i % 2), 14);
      deliver(release);
      remember(release);
      job();
    }
    return !robot.is_stopped();
  }
  void remember(const Bytes& bytes) {
    if (recorded_.size() < 64)
      recorded_.push_back(bytes);
    else
      recorded_[static_cast<std::size_t>(below(64))] = bytes;
  }

  Robot robot;
  rt::Nanoseconds now_ns{kOneSecond};

 private:
  std::mt19937_64 random_;
  std::vector<Bytes> recorded_;
};

// One halt among all that. True when the robot stood within the next jobs, and until the end.
template <class Robot>
bool is_obeyed(Network<Robot>& network, int round, bool at_any_age) {
  for (std::int64_t i = network.below(30); i > 0; --i) network.step(false);
  if (!network.set_free()) return false;
  // A release that somebody keeps back until the halt has come.
  const auto held =
      network.signed_bytes(Robot::release(), network.robot.newest() + 1 + network.below(900'000), 15);
  network.now_ns += kStep;
  if (network.robot.is_stopped()) return false;
  network.others();
  const std::int64_t sender = 1000 + round;
  const std::int64_t counter =
      network.one_in(5) ? static_cast<std::int64_t>(network.below(1LL << 62)) : network.known() + 1;
  auto halt = network.signed_bytes(Robot::stop(), counter, sender);
  rt::Nanoseconds waited = network.one_in(3) ? network.below((at_any_age ? 12 : 1) * kOneSecond) : 0;
  network.now_ns += waited;
  network.deliver(halt, waited);
  network.remember(halt);
  for (int i = 0; i < 60; ++i) {
    network.step(false);
    if (i == 2) network.deliver(held);
    if (i < 8) network.job();  // 17 before it at most, 8 a job
    if (i >= 8 && !network.robot.is_stopped()) return false;
  }
  const auto answer = answer_to(network.robot.lone.desk, sender);
  return answer && static_cast<Status>(answer->status) == Status::ok && answer->counter == counter;
}

template <class Robot>
void lose_no_halt(unsigned seed, bool at_any_age) {
  INFO("seed " << seed);
  Network<Robot> network(seed);
  int lost = 0;
  for (int round = 0; round < kRounds; ++round) lost += is_obeyed(network, round, at_any_age) ? 0 : 1;
  CHECK(lost == 0);
  const RequestDeskCounters counters = network.robot.lone.desk.counters();
  rt::for_each_scalar(counters, [](const char* name, int, std::uint64_t count) {
    INFO(name);
    // Everything that can go wrong has gone wrong, except what these senders do not do.
    if (std::string(name) != "not_finite" && std::string(name) != "out_of_range" &&
        std::string(name) != "wrong_session" && std::string(name) != "malformed")
      CHECK(count > 0);
  });
}

}  // namespace

TEST_CASE("none of 3,000 halts to a drive is lost among hostile and racing senders") {
  lose_no_halt<LoneDrive>(20261, true);
}

TEST_CASE("none of 3,000 stops to a pilot is lost among hostile and racing senders") {
  lose_no_halt<LonePilot>(20262, false);
}
