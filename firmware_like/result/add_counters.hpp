// SPDX-License-Identifier: BSD-3-Clause
// Counters of a part, by name, into a result.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "rt/describe.hpp"

namespace sortie::firmware {

/// Adds the counters of a part to a result, each as `prefix` and its name.
template <rt::Described Counters>
void add_counters(const std::string& prefix, const Counters& counters,
                  std::map<std::string, std::uint64_t>& out) {
  rt::for_each_scalar(counters, [&](const char* name, int, auto count) { out[prefix + name] = count; });
}

}  // namespace sortie::firmware
