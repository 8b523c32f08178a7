// SPDX-License-Identifier: BSD-3-Clause
// The declared table and the chains on the page about a run: what was computed beside what was measured.
#pragma once

#include <string>

#include "firmware_like/result/results.hpp"

namespace sortie::toolchain {

/// HTML of both, each empty where there is nothing to show.
std::string schedule_section(const firmware::Results& results);

}  // namespace sortie::toolchain
