// SPDX-License-Identifier: BSD-3-Clause
// What a simulated vehicle touched and how its flippers stood, as pictures over time.
#pragma once

#include <span>
#include <vector>

#include "firmware_like/log/contact_truth.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// Contacts by part, flipper angles asked for and actual, flipper torques. Empty without summaries.
std::vector<Plot> plot_contacts(std::span<const firmware::ContactSummary> contacts);

}  // namespace sortie::toolchain
