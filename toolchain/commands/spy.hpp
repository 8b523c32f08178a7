// SPDX-License-Identifier: BSD-3-Clause
// `sortie spy`: which LCM channels are alive, how fast, how regular, and what they say.
#pragma once

#include <iosfwd>
#include <string>

#include "drivers/lcm_url.hpp"

namespace sortie::toolchain {

/// What the command line asked for.
struct SpyOptions {
  std::string url{drivers::kDefaultLcmUrl};
  double seconds{0};   ///< listen that long, then print the table once; 0: until SIGINT, SIGTERM or SIGHUP
  bool json{false};    ///< one JSON object at the end instead of the table
  bool values{false};  ///< also the latest numbers of every message whose type is known
};

/// Listens and prints to `out`; words go to `err`. On a terminal the table is refreshed twice a second,
/// unless `seconds` or `json` is set. Memory is bounded whatever strangers send. Returns the exit code: 0
/// good, 2 the address makes no sense, 3 the group cannot be joined.
int run_spy(const SpyOptions& options, std::ostream& out, std::ostream& err);

}  // namespace sortie::toolchain
