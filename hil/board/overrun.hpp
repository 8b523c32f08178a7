// SPDX-License-Identifier: BSD-3-Clause
// A reader that is too slow for its bus: whether what the kernel dropped is counted.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::hil {

/// Sends `frames` to a port with the smallest receive buffer that nobody reads meanwhile, then one more,
/// reads all and prints one JSON object: sent, received, overrun, out_of_order. Exit code 0 when some were
/// dropped, each of them is counted and the others came in order.
int overrun(const std::string& interface, std::uint32_t frames);

}  // namespace sortie::hil
