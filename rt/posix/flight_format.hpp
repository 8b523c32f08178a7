// SPDX-License-Identifier: BSD-3-Clause
// The file of a flight ring, byte for byte: little endian, the same on 32 and 64 bit machines.
//
// header page | one ring of jobs a group | one ring of spans a track | one ring of events
//
// Every entry begins with a sequence word, 2n + 1 while entry n is being written and 2n + 2 when it is whole,
// and a check word over the rest, so that what a dying process left half done is recognised.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "rt/job_record.hpp"

namespace sortie::rt::posix {

static_assert(std::endian::native == std::endian::little, "a flight ring is written little endian");

inline constexpr char kFlightMagic[8] = {'S', 'O', 'R', 'T', 'R', 'I', 'N', 'G'};
inline constexpr std::uint32_t kFlightVersion = 1;
inline constexpr std::uint32_t kFlightHeaderBytes = 12288;
inline constexpr std::uint32_t kMaxFlightTracks = 16;
inline constexpr std::uint32_t kMaxSpanNames = 64;

/// Words (of 32 bits) of an entry; the first two are sequence and check.
inline constexpr std::uint32_t kJobWords = 8 + 2 * kMaxTasksPerGroup;
inline constexpr std::uint32_t kSpanWords = 6;
inline constexpr std::uint32_t kEventWords = 40;
inline constexpr std::uint32_t kEventText = (kEventWords - 7) * 4;

/// Where a ring lies. `slots` is a power of two.
struct FlightPlace {
  std::uint64_t offset{};
  std::uint32_t slots{};
  std::uint32_t reserved{};
};

/// One group of the executive.
struct FlightGroup {
  char name[24]{};
  std::uint32_t period_ticks{};
  std::uint32_t phase_ticks{};
  std::uint32_t deadline_ticks{};
  std::int32_t core{-1};
  std::uint32_t tasks{};
  std::uint32_t reserved{};
  std::uint32_t budget_us[kMaxTasksPerGroup]{};
  char task[kMaxTasksPerGroup][24]{};
  FlightPlace jobs;
};

/// A thread whose spans are kept. The first `groups` tracks are the groups' workers.
struct FlightTrackInfo {
  char name[24]{};
  FlightPlace spans;
};

/// First part of the header: written once, before the run.
struct FlightHeader {
  char magic[8]{};
  std::uint32_t version{};
  std::uint32_t header_bytes{};
  std::uint64_t file_bytes{};
  std::uint64_t check{};  ///< digest of this struct with check = 0
  std::int64_t base_tick_ns{};
  std::int64_t epoch_ns{};                ///< run clock at tick 0
  std::int64_t start_ns{};                ///< CLOCK_MONOTONIC when the run clock is 0
  std::int64_t utc_minus_monotonic_ns{};  ///< added to CLOCK_MONOTONIC it gives UTC
  std::uint64_t scene_hash{};
  std::uint32_t pid{};
  std::uint32_t groups{};
  std::uint32_t tracks{};
  std::uint32_t span_names{};
  char boot_id[40]{};
  char scene[48]{};
  char vehicle[32]{};
  char version_text[64]{};
  FlightGroup group[kMaxGroups];
  FlightTrackInfo track[kMaxFlightTracks];
  char span_name[kMaxSpanNames][32]{};
  FlightPlace events;
};

/// Last 128 bytes of the header page: changes during the run.
struct FlightState {
  std::uint32_t ended{};  ///< 1: the run ended by itself and the file is whole
  std::uint32_t reserved{};
  std::int64_t ended_ns{};              ///< run clock
  std::uint32_t running[kMaxGroups]{};  ///< 1 + index of the task that runs now in this group, or 0
  std::uint32_t signal{};               ///< that ended the process, as far as it could be caught; or 0
  std::int32_t signal_code{};    ///< si_code of it: above 0 a fault of the program, else somebody sent it
  std::uint32_t signal_track{};  ///< 1 + track of the thread that got it, or 0
  std::uint32_t reserved_too{};
  std::uint64_t signal_address{};  ///< si_addr of a fault
  std::int64_t signal_ns{};        ///< CLOCK_MONOTONIC
  std::uint32_t more[12]{};
};

inline constexpr std::uint32_t kFlightStateOffset = kFlightHeaderBytes - sizeof(FlightState);
static_assert(sizeof(FlightState) == 128 && sizeof(FlightPlace) == 16 && sizeof(FlightTrackInfo) == 40);
static_assert(sizeof(FlightGroup) == 24 + 24 + 48 + 288 + 16);
static_assert(sizeof(FlightHeader) == 88 + 40 + 48 + 32 + 64 + 8 * 400 + 16 * 40 + 64 * 32 + 16);
static_assert(sizeof(FlightHeader) <= kFlightStateOffset);

/// Fills a text of the header that is empty; what is too long is cut.
template <std::size_t N>
void copy_text(char (&to)[N], const std::string& from) {
  std::strncpy(to, from.c_str(), N - 1);
}

/// Check word of an entry over `count` words and its sequence word. Two running sums, so that order matters;
/// joined by an even factor, so that no change of a single word goes unseen.
inline std::uint32_t flight_check(std::uint32_t sequence, const std::uint32_t* words, std::uint32_t count) {
  std::uint32_t sum = sequence;
  std::uint32_t sums = 0x50f71e01u;
  for (std::uint32_t i = 0; i < count; ++i) {
    sum += words[i];
    sums += sum;
  }
  return sum + sums * 0x9e3779b2u;
}

/// The writing end of a ring: one thread at a time.
struct alignas(64) FlightWriter {
  std::uint32_t* first{};  ///< null: there is no ring
  std::uint32_t mask{};    ///< slots - 1
  std::uint32_t next{};

  /// Writes an entry of `kCount` words behind sequence and check. Readers may look at any time: they see it
  /// whole or know that it is not.
  template <std::uint32_t kCount>
  void add(const std::uint32_t (&words)[kCount]) noexcept {
    const auto store = [](std::uint32_t& word, std::uint32_t value, std::memory_order order) {
      std::atomic_ref<std::uint32_t>(word).store(value, order);
    };
    std::uint32_t* const entry = first + std::size_t{next & mask} * (kCount + 2);
    const std::uint32_t sequence = 2 * next + 2;
    ++next;
    store(entry[0], sequence - 1, std::memory_order_relaxed);
    // Released one by one: who sees one of these also sees that the entry is being written.
    store(entry[1], flight_check(sequence, words, kCount), std::memory_order_release);
    for (std::uint32_t i = 0; i < kCount; ++i) store(entry[2 + i], words[i], std::memory_order_release);
    store(entry[0], sequence, std::memory_order_release);
  }
};

}  // namespace sortie::rt::posix
