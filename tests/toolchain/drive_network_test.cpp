// SPDX-License-Identifier: BSD-3-Clause
// A live run that is driven over LCM, in a network of the test's own: by a friend, and not by a stranger.
#include <catch2/catch.hpp>

#include "firmware_like/link/secret.hpp"
#include "planner/drive_guard.hpp"
#include "planner/ugv_drive.hpp"
#include "tests/drivers/own_network.hpp"
#include "tests/firmware_like/request_rig.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/commands/request_client.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;
using std::chrono::milliseconds;

namespace {

const std::string kAddress{drivers::kDefaultLcmUrl};

constexpr RequestTopic kTopic = RequestKind<drivers::DriveRequestMessage>::kTopic;

// Repeats a request every 50 ms until the robot has admitted one and says what is waited for.
template <class Said>
bool repeat_until(RequestClient& client, const drivers::DriveRequestMessage& request, Said said) {
  const std::int64_t first = client.ask(request);
  for (int i = 0; i < 400; ++i) {
    static_cast<void>(client.listen(milliseconds(50)));
    if (client.is_admitted(first) && client.has_state() && said()) return true;
    client.ask(request);
  }
  return false;
}

// What the run says of itself, without the secret.
bool hear_answers(drivers::AnswersMessage& told) {
  drivers::LcmReceiver receiver(kAddress);
  for (int i = 0; i < 200; ++i) {
    drivers::ReceivedMessage received;
    if (receiver.receive(received, 100) == Status::ok && received.message.channel == "SORTIE_ANSWERS_drive" &&
        drivers::decode(received.message.payload, nullptr, told) == Status::ok)
      return true;
  }
  return false;
}

// Sends without the tag.
class Forger {
 public:
  explicit Forger(std::int64_t session) : session_(session) { REQUIRE(publisher_.active()); }
  void ask(drivers::DriveRequestMessage request, std::int64_t counter) {
    request.session = session_;
    request.counter = counter;
    request.utime = utc_us();
    const std::vector<std::uint8_t> bytes = bytes_of(request, nullptr);
    REQUIRE(publisher_.publish(drivers::kChannelDrive, bytes) == Status::ok);
  }

 private:
  std::int64_t session_;
  drivers::LcmPublisher publisher_{request_publisher(kAddress)};
};

}  // namespace

TEST_CASE("a live run is driven by who knows its secret, and its log replays to its digest") {
  if (const std::string why = test::enter_own_network(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  const TempFolder folder;
  const std::string secret = folder.write("secret", std::string(32, 'c') + "\n");
  std::filesystem::permissions(secret,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const std::string log = folder.file("live.lcm");
  HallOverLcm hall(log, {"drive.remote=true", "robot.name=hall",
                         "drive.max_command_age_ms=5000",  // the machine's mood is not what is tested
                         "parameters.secret_file=" + secret});
  const drivers::SipKey key = read_secret(secret);
  drivers::DriveRequestMessage go;
  go.speed_m_s = 0.2;
  RequestClient stranger(kAddress, std::nullopt, kTopic);
  CHECK_THROWS_AS(stranger.find("", milliseconds(20'000)), ProfileError);  // it needs the secret
  drivers::SipKey wrong = key;
  wrong[0] ^= 1u;
  RequestClient liar(kAddress, wrong, kTopic);
  CHECK_THROWS_AS(liar.find("", milliseconds(20'000)), ProfileError);

  RequestClient friendly(kAddress, key, kTopic);
  REQUIRE(friendly.find("", milliseconds(20'000)).empty());
  CHECK(friendly.robot() == "hall");
  RequestClient other(kAddress, key, kTopic);
  CHECK_THROWS_WITH(other.find("attic", milliseconds(20'000)), Catch::Contains("hall"));
  REQUIRE(other.find("hall", milliseconds(20'000)).empty());
  // Who has the run's number but not its secret asks in vain.
  drivers::AnswersMessage told;
  REQUIRE(hear_answers(told));
  Forger forger(told.session);
  for (int i = 0; i < 5; ++i) forger.ask(go, told.counter + 1 + i);
  const auto source = [&friendly] {
    return static_cast<planner::DriveSource>(static_cast<std::uint32_t>(friendly.value("source")));
  };
  const auto stop = [&friendly] { return static_cast<std::uint32_t>(friendly.value("stop")); };
  CHECK(repeat_until(friendly, go, [&] {
    return source() == planner::DriveSource::remote && friendly.value("speed_m_s") > 0.1;
  }));
  drivers::DriveRequestMessage halt;
  halt.mode = static_cast<std::uint32_t>(rt::DriveMode::halt);
  CHECK(repeat_until(friendly, halt, [&] {
    return (stop() & planner::kStopHalt) != 0 && friendly.value("speed_m_s") == 0.0;
  }));
  drivers::DriveRequestMessage release;
  release.mode = static_cast<std::uint32_t>(rt::DriveMode::release);
  CHECK(repeat_until(friendly, release, [&] { return source() != planner::DriveSource::remote; }));
  const LiveRunOutcome& run = hall.end();
  CHECK(run.results.counters.at("requests_admitted") > 2);
  CHECK(run.results.counters.at("requests_bad_tag") == 5);
  const ReplayOutcome outcome = replay_log(log);
  if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
  CHECK(outcome.results.digest == run.results.digest);
}
