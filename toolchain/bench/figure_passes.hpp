// SPDX-License-Identifier: BSD-3-Clause
// Which of a benchmark's figures are times, and what several runs of one benchmark say together.
#pragma once

#include <string>

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

/// True for what depends on the machine: times, what is per time, and plain numbers that have a range over
/// rounds. The others must be the same at every run, to the bit; a range in metres is one over seeds.
bool is_timed_figure(const firmware::Json& figure);

/// Takes a later run of the same program into `result`: of timed figures the range of ours, of the peer's and
/// of their ratio is widened to hold both runs, the value becomes the mean over the runs, and a goal is met
/// when every run met it. `passes`: how many `result` holds by now; `all_timed`: nothing in it is exact. A
/// figure that should be exact and is not goes to result["unsteady"] as "group: what, beside peer". The rest
/// of `later` is dropped.
void take_pass(firmware::Json& result, const firmware::Json& later, unsigned passes, bool all_timed);

/// ", 2 passes" where a result holds more than one.
std::string passes_words(const firmware::Json& result);

}  // namespace sortie::toolchain
