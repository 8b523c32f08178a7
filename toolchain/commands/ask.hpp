// SPDX-License-Identifier: BSD-3-Clause
// What the commands share that ask a live run for something: their options, and finding the run.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "drivers/channels.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/request_client.hpp"

namespace sortie::toolchain {

/// Exit codes of these commands, beside 2 for a wrong command line or secret.
enum AskExit : int {
  kTaken = 0,     ///< the run itself says that it is so
  kNotTaken = 1,  ///< it does not
  kUnheard = 3,   ///< no run was heard that takes such requests
};

/// Options of these commands.
struct AskOptions {
  std::string url{drivers::kDefaultLcmUrl};
  std::string secret;
  std::string whom;  ///< which run is meant; empty: the only one
  double seconds{5};
  bool json{};
};

/// Adds --lcm-url, --secret, --robot (of parameters --session), --seconds and --json.
void add_ask_options(firmware::Command& command, AskOptions& options, const firmware::RequestTopic& topic);

/// Finds the run and returns what `use` makes of it; kUnheard where there is none, and stderr says what is
/// missing. Throws ProfileError (the secret cannot be used or is another, several runs are heard) and
/// std::runtime_error (the address cannot be used).
int ask_run(const CommandContext& context, const AskOptions& options, const firmware::RequestTopic& topic,
            const std::function<int(RequestClient&)>& use);

/// Why it cannot be told what the robot makes of the requests from `first` on, for people; empty where it
/// can.
std::string why_not_admitted(const RequestClient& client, std::int64_t first);

/// Of seconds, rounded.
std::chrono::milliseconds ms_of(double seconds);

/// Well within a drive's max_command_age_ms.
inline constexpr std::chrono::milliseconds kRepeat{100};

}  // namespace sortie::toolchain
