// SPDX-License-Identifier: BSD-3-Clause
// Reads a flight ring: of a process that died, of one that still runs, or of another machine.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rt/job_record.hpp"
#include "rt/posix/flight_format.hpp"

namespace sortie::rt::posix {

/// A job as the ring holds it.
struct FlightJob {
  std::uint32_t group{};
  Tick tick{};
  Nanoseconds started_ns{};  ///< run clock
  Verdict verdict{};
  std::uint8_t level{};
  std::uint16_t shed{};
  std::uint16_t cut{};
  std::uint32_t tasks{};
  std::uint32_t duration_ns[kMaxTasksPerGroup]{};
  std::uint32_t units[kMaxTasksPerGroup]{};

  /// End of the last task, run clock.
  Nanoseconds ended_ns() const {
    Nanoseconds end = started_ns;
    for (std::uint32_t i = 0; i < tasks; ++i) end += duration_ns[i];
    return end;
  }
};

/// A stretch of a thread's time.
struct FlightSpan {
  std::uint32_t track{};
  std::string name;
  Nanoseconds begin_ns{};  ///< run clock
  Nanoseconds duration_ns{};
};

/// Something noted in words.
struct FlightEvent {
  Nanoseconds time_ns{};  ///< run clock
  Tick tick{};
  std::string text;
};

/// Everything that a ring holds, whole entries only, each list by time.
class FlightReader {
 public:
  /// Throws std::runtime_error (path, what, where in the file, cure) when it cannot be read, is no ring, is
  /// of another version, is cut off, or its header is damaged.
  explicit FlightReader(const std::string& path);

  /// True when the file begins as a flight ring does. Never throws.
  static bool is_ring(const std::string& path) noexcept;

  /// True when there is nothing in the file but zeros: what is left where a ring's making was killed before
  /// its first word. Reads up to the first other byte. Never throws.
  static bool is_blank(const std::string& path) noexcept;

  /// True for a ring with a whole header whose run ended by itself. Another user's file, and a link, are
  /// none. Reads the header alone. Never throws.
  static bool has_ended(const std::string& path) noexcept;
  /// The same for one whose run has not ended and whose writer is gone.
  static bool was_left(const std::string& path) noexcept;

  const FlightHeader& header() const { return *header_; }
  const std::vector<FlightJob>& jobs() const { return jobs_; }
  const std::vector<FlightSpan>& spans() const { return spans_; }
  const std::vector<FlightEvent>& events() const { return events_; }
  /// True when the run ended by itself.
  bool ended() const { return state_.ended == 1; }
  /// What changed during the run: the signal that ended it among it.
  const FlightState& state() const { return state_; }
  /// Index of the task that was running in a group when the file was read, or -1.
  int running(std::uint32_t group) const;
  /// Entries that were being written at that moment: at most one a ring.
  std::uint32_t torn() const { return torn_; }
  /// Entries that are neither whole nor being written: the file was changed.
  std::uint32_t damaged() const { return damaged_; }
  /// True when the process that writes it was still there as it was opened: it holds a lock on the file.
  bool writer_lives() const { return writer_lives_; }

 private:
  template <class Take>
  void read_ring(const std::vector<std::uint32_t>& words, const FlightPlace& place, std::uint32_t count,
                 Take take);
  void take_header(const std::string& path, const std::vector<char>& bytes);
  void read_jobs(const std::vector<std::uint32_t>& words);
  void read_spans(const std::vector<std::uint32_t>& words);

  std::unique_ptr<FlightHeader> header_;
  FlightState state_;
  std::vector<FlightJob> jobs_;
  std::vector<FlightSpan> spans_;
  std::vector<FlightEvent> events_;
  std::uint32_t torn_{};
  std::uint32_t damaged_{};
  bool writer_lives_{};
};

/// Digest of a header with its check left out.
std::uint64_t flight_header_check(const FlightHeader& header);

}  // namespace sortie::rt::posix
