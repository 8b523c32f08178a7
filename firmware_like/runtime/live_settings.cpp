// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/live_settings.hpp"

namespace sortie::firmware {

namespace {
rt::Nanoseconds microseconds(double us) { return static_cast<rt::Nanoseconds>(us * 1e3); }
}  // namespace

rt::posix::LiveOptions read_live_settings(Profile& profile) {
  rt::posix::LiveOptions live;
  live.margin.first_ns = microseconds(
      profile.number("live.margin_us",
                     {50, 0, 10'000, "us", "workers sleep to this long before a release and spin the rest"}));
  live.margin.adapts =
      profile.flag("live.margin_adapts", true, "the margin follows what wake-ups take on this machine");
  live.margin.least_ns = microseconds(
      profile.number("live.margin_least_us", {5, 0, 10'000, "us", "lower bound of an adapting margin"}));
  live.margin.most_ns =
      microseconds(profile.number("live.margin_most_us", {60, 0, 10'000, "us", "upper bound of the margin"}));
  if (live.margin.least_ns > live.margin.most_ns)
    profile.fail("live.margin_least_us", "must not be above live.margin_most_us");
  live.most_spinning = profile.number(
      "live.most_spinning", {0.06, 0, 1, "", "most of a core that spinning may take, bounds the margin"});
  live.cut_at = profile.number(
      "live.cut_at",
      {0.9, 0, 1, "", "anytime tasks are cut at this share of the way to the deadline, 0: never"});
  live.supervised = profile.flag("live.supervised", true, "watchdog and degrade ladder above the workers");
  live.attribution =
      profile.flag("live.attribution", true,
                   "find the cause of each delay above live.delay_us: one more system call a tick");
  live.delay_threshold_ns = microseconds(
      profile.number("live.delay_us", {100, 1, 1e6, "us", "delays up to here need no explanation"}));
  live.stuck_limit_ns =
      microseconds(1e3 * profile.number("live.stuck_exit_ms",
                                        {1000, 0, 1e6, "ms",
                                         "a task that is stuck for so long ends the process, 0: never"}));
  live.ladder.most_load = profile.number(
      "ladder.most_load",
      {0.85, 0.1, 0.9, "", "above this share of a core, tasks of criticality C and B give way"});
  live.ladder.return_load =
      profile.number("ladder.return_load",
                     {0.75, 0.05, 0.9, "", "they come back when the core is expected to stay below this"});
  if (live.ladder.return_load >= live.ladder.most_load)
    profile.fail("ladder.return_load", "must be below ladder.most_load, or the ladder would swing");
  return live;
}

RunOutlets read_run_outlets(Profile& profile) {
  RunOutlets outlets;
  outlets.telemetry = profile.flag("live.telemetry", true,
                                   "a live run tells over LCM what it does, and answers requests; without it "
                                   "nobody can make one");
  outlets.recorder = profile.flag("live.recorder", true, "runs and replays of this scene can be recorded");
  return outlets;
}

}  // namespace sortie::firmware
