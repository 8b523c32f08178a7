// SPDX-License-Identifier: BSD-3-Clause
// How far apart data of two threads must lie.
#pragma once

#include <cstddef>

namespace sortie::rt {

/// Distance that keeps two threads off each other's cache line. 64 bytes on x86-64 and Cortex-A.
inline constexpr std::size_t kCacheLineBytes = 64;

}  // namespace sortie::rt
