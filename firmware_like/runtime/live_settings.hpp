// SPDX-License-Identifier: BSD-3-Clause
// How a scene wants its live runs treated: margins, watchdog, ladder.
#pragma once

#include "firmware_like/scene/profile.hpp"
#include "rt/posix/live_runner.hpp"

namespace sortie::firmware {

/// What a scene's runs may give to the outside. Neither changes what the tasks put out.
struct RunOutlets {
  bool telemetry{true};  ///< over LCM
  bool recorder{true};   ///< into a log, where one is asked for

  SORTIE_KEYS(c, key) {
    key("telemetry", c.telemetry,
        {"a live run tells over LCM what it does, and answers requests; without it nobody can make one"});
    key("recorder", c.recorder, {"runs and replays of this scene can be recorded"});
  }
};

/// live.telemetry and live.recorder. Throws ProfileError.
RunOutlets read_run_outlets(Profile& profile);

/// The other keys below [live] and [ladder]. Times and threads of the run itself (start, length) are the
/// caller's. Throws ProfileError.
rt::posix::LiveOptions read_live_settings(Profile& profile);

}  // namespace sortie::firmware
