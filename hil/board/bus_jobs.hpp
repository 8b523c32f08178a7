// SPDX-License-Identifier: BSD-3-Clause
// What a board's jobs do to buses and processes. Linux, root; each prints what went wrong to stderr and
// returns an exit code.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::hil {

/// Becomes a program that sees one CAN controller and no other network: the node at the far end of a bus.
/// Returns only when that failed.
int run_isolated(const std::string& interface, std::uint32_t bits_per_s, char** program);

/// Writes every frame of a bus into a candump log until SIGTERM. Stamps are CLOCK_MONOTONIC.
int watch_bus(const std::string& interface, const std::string& file);

/// Kills a process (SIGKILL) and prints CLOCK_MONOTONIC in seconds, as the watcher's log has it.
int kill_process(int process);

}  // namespace sortie::hil
