// SPDX-License-Identifier: BSD-3-Clause
// What one job consumed, decided and produced: all that a replay needs to take the same decisions again.
#pragma once

#include <cstdint>

#include "rt/limits.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// Outcome of a job, decided exactly once. A missed job ran, but no other group ever saw its outputs.
enum class Verdict : std::uint8_t { pending = 0, done = 1, missed = 2 };

/// The samples that a job took from one stream: `count` of them from sequence number `first`.
struct StreamRange {
  std::uint64_t first{};
  std::uint32_t count{};
  std::uint16_t stream{};
};

/// The writer's jobs that a job took from another group: first..last, or none (last < first).
struct InputRange {
  std::int64_t first{};
  std::int64_t last{-1};
};

/// One executed job. Plain, fixed size; travels through a ring to the recorder.
struct JobRecord {
  Tick tick{};          ///< release
  std::uint64_t job{};  ///< number of the release within the group
  std::uint16_t group{};
  Verdict verdict{Verdict::pending};
  std::uint8_t streams{};
  std::uint8_t inputs{};
  std::uint8_t tasks{};
  std::uint8_t level{};  ///< of the degrade ladder, as it stood when the job began (rt/ladder.hpp)
  std::uint16_t shed{};  ///< bit i: task i of the group was left out; follows from `level` and the table
  std::uint16_t cut{};   ///< bit i: the wall-clock guard stopped task i at `units[i]`
  StreamRange stream[kMaxStreamsPerGroup]{};
  InputRange input[kMaxInputsPerGroup]{};
  std::uint64_t digest[kMaxTasksPerGroup]{};
  std::uint32_t units[kMaxTasksPerGroup]{};
  // Measured, and therefore never part of a digest.
  Nanoseconds started_ns{};                        ///< when the first task began, on the run's clock
  std::uint32_t duration_ns[kMaxTasksPerGroup]{};  ///< wall time of each task, saturated at 2^32 - 1
  std::uint32_t field_bytes{};                     ///< used bytes of `fields`; 0 when fields are not recorded
  std::uint8_t fields[kMaxFieldBytes];
};

}  // namespace sortie::rt
