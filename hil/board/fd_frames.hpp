// SPDX-License-Identifier: BSD-3-Clause
// CAN FD through a real kernel: frames of all sizes beside classical ones.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::hil {

/// Sends `frames` of both kinds and all sizes from one port to another of an interface that carries FD,
/// beside a port for classical frames alone, and prints one JSON object: sent, received, wrong (lost, changed
/// or out of order), classical (sent), classical_received, heap_calls, and what `without_fd` says when it is
/// asked for FD. Exit code 0 when nothing is wrong, the classical port has seen all classical frames and no
/// others, and `without_fd` was refused.
int fd_frames(const std::string& interface, const std::string& without_fd, std::uint32_t frames);

}  // namespace sortie::hil
