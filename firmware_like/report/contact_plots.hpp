// SPDX-License-Identifier: BSD-3-Clause
// What a simulated vehicle touched and how its flippers stood, as pictures over time.
#pragma once

#include <span>
#include <vector>

#include "firmware_like/evaluation/contact_truth.hpp"
#include "firmware_like/report/svg.hpp"

namespace sortie::firmware {

/// Contacts by part, flipper angles asked for and actual, flipper torques. Empty without summaries.
std::vector<Plot> plot_contacts(std::span<const ContactSummary> contacts);

}  // namespace sortie::firmware
