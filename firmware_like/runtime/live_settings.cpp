// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/live_settings.hpp"

namespace sortie::firmware {

rt::posix::LiveOptions read_live_settings(Profile& profile) {
  rt::posix::LiveOptions live;
  live.stuck_limit_ns = rt::kNanosecondsPerSecond;
  profile.read("live", live);
  if (live.margin.least_ns > live.margin.most_ns)
    profile.fail("live.margin_least_us", "must not be above live.margin_most_us");
  if (live.ladder.return_load >= live.ladder.most_load)
    profile.fail("ladder.return_load", "must be below ladder.most_load, or the ladder would swing");
  return live;
}

RunOutlets read_run_outlets(Profile& profile) {
  RunOutlets outlets;
  profile.read("live", outlets);
  return outlets;
}

}  // namespace sortie::firmware
