// SPDX-License-Identifier: BSD-3-Clause
// What a board's jobs do to buses and processes. Linux, root; each prints what went wrong to stderr and
// returns an exit code.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::hil {

/// Says what went wrong. Returns 1.
int complain(const std::string& problem);

/// Becomes a program that sees one CAN controller and no other network: the node at the far end of a bus.
/// Returns only when that failed.
int run_isolated(const std::string& interface, std::uint32_t bits_per_s, char** program);

/// Writes every frame of a bus into a candump log until SIGTERM. Stamps are CLOCK_MONOTONIC.
int watch_bus(const std::string& interface, const std::string& file);

/// Kills a process (SIGKILL) and prints CLOCK_MONOTONIC in seconds, as the watcher's log has it.
int kill_process(int process);

/// CAN FD through a real kernel. Sends `frames` of both kinds and all sizes from one port to another of an
/// interface that carries FD, beside a port for classical frames alone, and prints one JSON object: sent,
/// received, wrong (lost, changed or out of order), classical (sent), classical_received, heap_calls, and
/// what `without_fd` says when it is asked for FD. Exit code 0 when nothing is wrong, the classical port has
/// seen all classical frames and no others, and `without_fd` was refused.
int fd_frames(const std::string& interface, const std::string& without_fd, std::uint32_t frames);

/// What flood() sends. The far end is a process of its own, of lower priority; it answers every frame.
struct FloodConfig {
  std::string near;        ///< interface of the real-time thread
  std::string far;         ///< interface of the process that answers
  std::uint32_t frames{};  ///< each way
  std::uint32_t per_ms{};
};

/// Many frames both ways by a periodic real-time thread. Sends, takes the answers and prints one JSON object:
/// sent, received, out_of_order, lost, refused, heap_calls, overrun, page_faults, releases,
/// late_{min,p50,p99,max}_ns (wake-up after its release), work_max_ns. Exit code 0 when every frame came back
/// in order and nothing took memory.
int flood(const FloodConfig& config);

/// A reader that is too slow for its bus. Sends `frames` to a port with the smallest receive buffer that
/// nobody reads meanwhile, then one more, reads all and prints one JSON object: sent, received, overrun,
/// out_of_order. Exit code 0 when some were dropped, each of them is counted and the others came in order.
int overrun(const std::string& interface, std::uint32_t frames);

/// What a network can send to a robot that listens: noise, LCM messages of unknown channels, fragments and
/// requests with wrong tags and changed bytes, a fifth of each, to "udpm://group:port". Prints one JSON
/// object: datagrams, refused (by the system). Exit code 0 when all went out.
int storm(const std::string& url, std::uint32_t datagrams, std::uint32_t per_ms);

}  // namespace sortie::hil
