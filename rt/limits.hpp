// SPDX-License-Identifier: BSD-3-Clause
// How large the tables of the executive are, and how far apart data of two threads lie. SORTIE_SMALL_BOARD,
// set for the whole program, makes tables fit a microcontroller; outputs and digests do not depend on it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sortie::rt {

#ifdef SORTIE_SMALL_BOARD
inline constexpr std::uint32_t kMaxGroups = 2;
inline constexpr std::uint32_t kMaxTasks = 8;
inline constexpr std::uint32_t kMaxStreams = 4;
inline constexpr std::uint32_t kMaxTasksPerGroup = 4;
inline constexpr std::uint32_t kMaxStreamsPerGroup = 4;
inline constexpr std::uint32_t kMaxInputsPerGroup = 2;
inline constexpr std::uint32_t kMaxOutletsPerGroup = 2;
inline constexpr std::uint32_t kMaxFieldBytes = 512;
/// Buckets of a latency histogram per doubling, as a power of two: steps of 50 %, 0.6 kB.
inline constexpr std::uint32_t kHistogramSubBits = 1;
inline constexpr std::uint32_t kMaxArenaPools = 24;
#else
/// Most groups, tasks and ports that one executive holds. Fixed, so that a job record has a fixed size.
inline constexpr std::uint32_t kMaxGroups = 8;
inline constexpr std::uint32_t kMaxTasks = 32;
inline constexpr std::uint32_t kMaxStreams = 16;
inline constexpr std::uint32_t kMaxTasksPerGroup = 12;
inline constexpr std::uint32_t kMaxStreamsPerGroup = 8;
inline constexpr std::uint32_t kMaxInputsPerGroup = 8;
inline constexpr std::uint32_t kMaxOutletsPerGroup = 4;
/// Room for the outputs of one job when fields are recorded.
inline constexpr std::uint32_t kMaxFieldBytes = 2048;
/// Buckets of a latency histogram per doubling, as a power of two: steps of 1.6 %, 15.9 kB.
inline constexpr std::uint32_t kHistogramSubBits = 6;
/// Named allocations that an arena and its report can hold; more are refused.
inline constexpr std::uint32_t kMaxArenaPools = 192;
#endif

/// Distance that keeps two threads off each other's cache line. 64 bytes on x86-64 and Cortex-A.
inline constexpr std::size_t kCacheLineBytes = 64;

}  // namespace sortie::rt
