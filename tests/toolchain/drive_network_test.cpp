// SPDX-License-Identifier: BSD-3-Clause
// A live run that is driven over LCM, in a network of the test's own: by a friend, and not by a stranger.
#include <catch2/catch.hpp>

#include "firmware_like/commands/drive_client.hpp"
#include "firmware_like/commands/parameter_client.hpp"
#include "firmware_like/secret.hpp"
#include "planner/drive_guard.hpp"
#include "planner/ugv_drive.hpp"
#include "tests/drivers/own_network.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::testing;
using std::chrono::milliseconds;

namespace {

const std::string kAddress{drivers::kDefaultLcmUrl};

// Repeats a request every 50 ms until the drive says what is waited for.
template <class Said>
bool repeat_until(DriveClient& client, const drivers::DriveRequestMessage& request, Said said) {
  for (int i = 0; i < 400; ++i) {
    client.ask(request);
    static_cast<void>(client.listen(milliseconds(50)));
    if (said(client.state())) return true;
  }
  return false;
}

bool from_outside(const DriveState& state) {
  return state.source == static_cast<std::uint32_t>(planner::DriveSource::remote);
}

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
  HallOverLcm hall(log, {"drive.remote=true",
                         "drive.max_command_age_ms=5000",  // the machine's mood is not what is tested
                         "parameters.secret_file=" + secret});
  const drivers::SipKey key = read_secret(secret);
  ParameterClient finder(kAddress, key);
  const auto heard = finder.find_runs(0, milliseconds(20'000));
  REQUIRE(heard.size() == 1);
  finder.choose(heard[0]);
  CHECK(finder.run().keyed);

  drivers::DriveRequestMessage go;
  go.speed_m_s = 0.2;
  DriveClient stranger(kAddress, std::nullopt, heard[0]);
  REQUIRE(stranger.listen(milliseconds(20'000)));
  const std::int64_t first = stranger.ask(go);
  for (int i = 0; i < 4; ++i) stranger.ask(go);
  REQUIRE(stranger.listen(milliseconds(20'000)));
  CHECK_FALSE(stranger.has_taken(first));

  DriveClient friendly(kAddress, key, heard[0]);
  REQUIRE(friendly.listen(milliseconds(20'000)));
  CHECK(repeat_until(friendly, go, [](const DriveState& s) { return from_outside(s) && s.speed_m_s > 0.1; }));
  CHECK(friendly.has_taken(first));  // both began to count where the drive was
  drivers::DriveRequestMessage halt;
  halt.mode = static_cast<std::int32_t>(rt::DriveMode::halt);
  CHECK(repeat_until(friendly, halt, [](const DriveState& s) {
    return (s.stop & planner::kStopHalt) != 0 && s.speed_m_s == 0.0;
  }));
  drivers::DriveRequestMessage release;
  release.mode = static_cast<std::int32_t>(rt::DriveMode::release);
  CHECK(repeat_until(friendly, release, [](const DriveState& s) { return !from_outside(s); }));
  const LiveRunOutcome& run = hall.end();
  CHECK(run.results.counters.at("requests_admitted") > 2);
  CHECK(run.results.counters.at("requests_bad_tag") == 5);
  const ReplayOutcome outcome = replay_log(log);
  if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
  CHECK(outcome.results.digest == run.results.digest);
}
