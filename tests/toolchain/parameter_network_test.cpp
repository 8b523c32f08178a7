// SPDX-License-Identifier: BSD-3-Clause
// Requests for parameters over LCM, in a network of the test's own: from friends, from strangers, and from
// nobody.
#include <catch2/catch.hpp>
#include <thread>

#include "firmware_like/link/request_door.hpp"
#include "tests/drivers/own_network.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/commands/request_client.hpp"
#include "toolchain/commands/set.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;
using std::chrono::milliseconds;

namespace {

const std::string kUrl{drivers::kDefaultLcmUrl};

bool has_network() {
  const std::string why = test::enter_own_network();
  if (!why.empty()) WARN("skipped: " << why);
  return why.empty();
}

std::string secret_file(const TempFolder& folder, const std::string& name, char digit) {
  const std::string path = folder.write(name, std::string(32, digit) + "\n");
  std::filesystem::permissions(path,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  return path;
}

/// Sends requests as they come into a stranger's mind.
class Sender {
 public:
  Sender()
      : publisher_([] {
          drivers::LcmPublisherConfig config;
          config.url = kUrl;
          return config;
        }()) {
    REQUIRE(publisher_.active());
  }
  void raw(const std::vector<std::uint8_t>& bytes) {
    REQUIRE(publisher_.publish(drivers::kChannelSet, bytes) == Status::ok);
    ++sent;
  }
  void ask(const drivers::SetParameter& request, const drivers::SipKey* key) {
    std::vector<std::uint8_t> bytes(256);
    std::size_t size = 0;
    REQUIRE(drivers::encode(request, key, bytes, size) == Status::ok);
    bytes.resize(size);
    raw(bytes);
  }
  std::uint64_t sent{};

 private:
  drivers::LcmPublisher publisher_;
};

std::uint64_t handled(const ParameterDeskCounters& c) {
  return c.admitted + c.unknown + c.not_finite + c.out_of_range + c.full + c.malformed + c.bad_tag +
         c.wrong_session + c.wrong_time + c.stale;
}

// Every datagram is counted exactly once, by its reason.
void wait_for(RequestDoor& desk, std::uint64_t sent) {
  for (int i = 0; i < 2000 && handled(desk.parameters().counters()) < sent; ++i) {
    desk.poll(1);
    std::this_thread::sleep_for(milliseconds(5));
  }
  REQUIRE(handled(desk.parameters().counters()) == sent);
}

}  // namespace

TEST_CASE("the desk takes requests with the right tag, session and counter, and counts all others") {
  if (!has_network()) return;
  const TempFolder folder;
  Runtime runtime(load_scene("ugv_hall", {"limits.voxels=1024", "parameters.max_request_age_ms=0",
                                          "parameters.remote=true",
                                          "parameters.secret_file=" + secret_file(folder, "s", '7')}),
                  own_vehicles(), RuntimeStart{});
  RequestDoor desk(runtime);
  REQUIRE(desk.open(kUrl).empty());
  const drivers::SipKey key = read_secret(folder.file("s"));
  drivers::SipKey other = key;
  other[3] ^= 4u;
  const std::int64_t session = desk.describe().session;
  CHECK(session != 0);
  Sender sender;
  const auto speed = [](double value) { return rt::ParameterChange{0, "drive.max_speed_m_s", value}; };
  sender.raw({1, 2, 3});
  sender.raw(std::vector<std::uint8_t>(2000, 0));
  sender.ask({1, session, 5, 1, speed(0.1)}, nullptr);
  sender.ask({1, session, 5, 1, speed(0.1)}, &other);
  sender.ask({1, session + 1, 5, 1, speed(0.1)}, &key);
  sender.ask({1, session, 5, 10, speed(0.2)}, &key);  // good
  sender.ask({1, session, 5, 10, speed(0.2)}, &key);  // the same datagram again
  sender.ask({1, session, 5, 9, speed(0.3)}, &key);   // overtaken
  sender.ask({1, session, 5, 11, speed(99)}, &key);
  sender.ask({1, session, 5, 12, {0, "drive.max", 0.3}}, &key);
  sender.ask({1, session, 5, 13, speed(std::numeric_limits<double>::quiet_NaN())}, &key);
  wait_for(desk, sender.sent);
  const ParameterDeskCounters counters = desk.parameters().counters();
  CHECK(counters.malformed == 2);
  CHECK(counters.bad_tag == 2);
  CHECK(counters.wrong_session == 1);
  CHECK(counters.stale == 2);
  CHECK(counters.admitted == 1);
  CHECK(counters.out_of_range == 1);
  CHECK(counters.unknown == 1);
  CHECK(counters.not_finite == 1);
  const drivers::ParametersMessage said = desk.describe();
  CHECK(said.keyed);
  CHECK(said.counter == 13);
  REQUIRE(said.answers.size() == 4);  // strangers and repeats get none
  CHECK(static_cast<Status>(said.answers[0].status) == Status::ok);
  CHECK(static_cast<Status>(said.answers[1].status) == Status::out_of_range);
}

TEST_CASE("the desk refuses a friend's request that was held back, and takes the same of now") {
  if (!has_network()) return;
  const TempFolder folder;
  Runtime runtime(load_scene("ugv_hall", {"limits.voxels=1024", "parameters.remote=true",
                                          "parameters.secret_file=" + secret_file(folder, "s", '7')}),
                  own_vehicles(), RuntimeStart{});
  RequestDoor desk(runtime);
  REQUIRE(desk.open(kUrl).empty());
  const drivers::SipKey key = read_secret(folder.file("s"));
  const std::int64_t session = desk.describe().session;
  const auto now_us = std::chrono::duration_cast<std::chrono::microseconds>(
                          std::chrono::system_clock::now().time_since_epoch())
                          .count();
  Sender sender;
  sender.ask({now_us - 600'000'000, session, 5, 1, {0, "drive.max_speed_m_s", 0.1}}, &key);
  sender.ask({now_us + 600'000'000, session, 5, 2, {0, "drive.max_speed_m_s", 0.1}}, &key);
  sender.ask({now_us, session, 5, 3, {0, "drive.max_speed_m_s", 0.2}}, &key);
  wait_for(desk, sender.sent);
  CHECK(desk.parameters().counters().wrong_time == 2);
  CHECK(desk.parameters().counters().admitted == 1);
}

TEST_CASE("a flood of requests is refused beyond the ring and counted") {
  if (!has_network()) return;
  Runtime runtime(load_scene("ugv_hall", {"limits.voxels=1024", "parameters.remote=true",
                                          "parameters.without_secret=true"}),
                  own_vehicles(), RuntimeStart{});
  RequestDoor desk(runtime);
  CHECK(desk.open(kUrl).find("anybody") != std::string::npos);
  const std::int64_t session = desk.describe().session;
  Sender sender;
  for (std::int64_t i = 1; i <= 60; ++i)
    sender.ask({1, session, 5, i, {0, "drive.max_speed_m_s", 0.3}}, nullptr);
  wait_for(desk, sender.sent);
  CHECK(desk.parameters().counters().admitted == kWaitingChanges);
  CHECK(desk.parameters().counters().full == 60 - kWaitingChanges);
  CHECK(desk.describe().answers.size() == 16);
}

TEST_CASE("without a secret nothing is taken, and the cure is told") {
  if (!has_network()) return;
  Runtime runtime(
      load_scene("ugv_hall", {"limits.voxels=1024", "parameters.remote=true", "drive.remote=true"}),
      own_vehicles(), RuntimeStart{});
  RequestDoor desk(runtime);
  const std::string warning = desk.open(kUrl);
  CHECK(warning.find("no requests are taken") != std::string::npos);
  CHECK(warning.find("secret_file") != std::string::npos);
  CHECK_FALSE(desk.describe().remote);
  Sender sender;
  sender.ask({1, desk.describe().session, 5, 1, {0, "drive.max_speed_m_s", 0.1}}, nullptr);
  for (int i = 0; i < 20; ++i) {
    desk.poll(i);
    std::this_thread::sleep_for(milliseconds(5));
  }
  CHECK(handled(desk.parameters().counters()) == 0);
}

TEST_CASE("without remote control nothing is listened to") {
  if (!has_network()) return;
  Runtime runtime(load_scene("ugv_hall", {"limits.voxels=1024"}), own_vehicles(), RuntimeStart{});
  RequestDoor desk(runtime);
  CHECK(desk.open(kUrl).empty());
  CHECK_FALSE(desk.describe().remote);
  Sender sender;
  sender.ask({1, 0, 5, 1, {0, "drive.max_speed_m_s", 0.1}}, nullptr);
  for (int i = 0; i < 20; ++i) {
    desk.poll(i);
    std::this_thread::sleep_for(milliseconds(5));
  }
  CHECK(handled(desk.parameters().counters()) == 0);
}

TEST_CASE("a live run is heard, takes a friend's changes, and its log replays to its digest") {
  if (!has_network()) return;
  const TempFolder folder;
  const std::string log = folder.file("live.lcm");
  HallOverLcm hall(log,
                   {"parameters.remote=true", "parameters.secret_file=" + secret_file(folder, "s", 'a')});
  constexpr RequestTopic kTopic = RequestKind<drivers::SetParameter>::kTopic;
  constexpr milliseconds kPatience{20'000};
  RequestClient friendly(kUrl, read_secret(folder.file("s")), kTopic);
  REQUIRE(friendly.find("", kPatience).empty());
  CHECK(friendly.parameters().remote);
  CHECK(friendly.parameters().keyed);
  CHECK(friendly.parameters().parameters.size() == 9);
  const ChangeOutcome slower = ask_for_change(friendly, "drive.max_speed_m_s", 0.25, kPatience);
  CHECK(slower.end == ChangeEnd::in_force);
  CHECK(slower.before == 0.5);
  CHECK(slower.after == 0.25);
  const ChangeOutcome absurd = ask_for_change(friendly, "drive.max_speed_m_s", 1e9, kPatience);
  CHECK(absurd.end == ChangeEnd::refused);
  CHECK(absurd.status == Status::out_of_range);
  CHECK(absurd.after == 0.25);
  CHECK(ask_for_change(friendly, "map.min_range_m", 60, kPatience).end == ChangeEnd::not_applied);

  RequestClient stranger(kUrl, read_secret(secret_file(folder, "t", 'b')), kTopic);
  CHECK_THROWS_WITH(stranger.find("attic", milliseconds(1500)), Catch::Contains(friendly.robot()));
  REQUIRE(stranger.find(friendly.robot(), kPatience).empty());
  CHECK(ask_for_change(stranger, "drive.max_speed_m_s", 2, milliseconds(700)).end == ChangeEnd::no_answer);
  // Asked again before anybody has answered it is the same change, which is made once.
  drivers::SetParameter twice;
  twice.change = {0, "drive.max_speed_m_s", 0};
  const std::int64_t first = stranger.ask(twice);
  CHECK(stranger.ask(twice) == first);
  const LiveRunOutcome& run = hall.end();
  CHECK(run.results.counters.at("parameters_admitted") == 2);
  CHECK(run.results.counters.at("parameters_applied") == 1);
  CHECK(run.results.counters.at("parameters_not_applied") == 1);
  CHECK(run.results.counters.at("parameters_bad_tag") > 0);
  for (const bool threaded : {false, true}) {
    ReplayOptions replaying;
    replaying.threaded = threaded;
    const ReplayOutcome outcome = replay_log(log, replaying);
    if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
    CHECK(outcome.results.digest == run.results.digest);
    CHECK(outcome.results.counters.at("parameters_applied") == 1);
  }
}
