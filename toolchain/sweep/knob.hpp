// SPDX-License-Identifier: BSD-3-Clause
// The knobs of a sweep: keys of a profile with the values to try, and the grid that they span.
#pragma once

#include <string>
#include <vector>

namespace sortie::toolchain {

/// One key of a profile and the values it takes, as TOML text each.
struct SweepKnob {
  std::string key;
  std::vector<std::string> values;
};

/// Reads "key=v1,v2,v3". Commas in brackets and quotes belong to the value. Blanks around values are dropped.
/// Throws ProfileError (exit code 2) with a cure when there is no key, no value, an empty or a repeated
/// value.
SweepKnob parse_knob(const std::string& text);

/// Reads all knobs; a key that is given twice is a ProfileError, too, and so are more than `most_cells`
/// cells.
std::vector<SweepKnob> parse_knobs(const std::vector<std::string>& texts, std::size_t most_cells = 4096);

/// Every combination, one value a knob each, in the order of nested loops: the first knob turns slowest.
std::vector<std::vector<std::string>> span_grid(const std::vector<SweepKnob>& knobs);

/// True if `value` is what the profile says anyway: the same number, or the same text.
bool same_value(const std::string& value, const std::string& other);

}  // namespace sortie::toolchain
