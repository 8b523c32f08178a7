// SPDX-License-Identifier: BSD-3-Clause
// Flight recorder: the last ticks of a run in a file-backed map that survives the process. Killed, crashed or
// stuck, the file still holds every job up to the last, and which task was running.
//
// Where to put the file. The map is shared, so what was stored is in the kernel's page cache the moment it is
// stored, and stays there when the process dies in whatever way. It does not survive a loss of power or a
// crash of the kernel unless it was written back to a disk: for that there is the log. Write-back is also why
// the file belongs on a memory file system (/dev/shm, /run): a disk file system makes each page read-only
// while it writes it, every few seconds, and the next store into it takes a page fault and may wait for the
// disk. On a memory file system nothing is ever written back; a store there is a store.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "rt/job_record.hpp"
#include "rt/posix/file_place.hpp"
#include "rt/posix/flight_format.hpp"
#include "rt/posix/trace_span.hpp"

namespace sortie::rt::posix {

/// What a flight ring is to hold.
struct FlightPlan {
  /// What is known of the run and of its groups. The ring itself fills in what follows from the file and the
  /// process: magic to check, places, tracks, names of spans, pid and boot.
  FlightHeader header;
  std::vector<std::string> more_tracks;  ///< threads beside the workers whose spans are kept
  std::uint32_t ticks{10'000};           ///< kept at least, of every group
  std::uint32_t spans{4096};             ///< kept of every track, rounded up to a power of two
  std::uint32_t events{256};             ///< kept, rounded up to a power of two
  bool waits{};                          ///< takes its place with take_place(), not when it is made
};

/// The writing side. All memory is mapped and touched at construction; afterwards a job costs about 20 ns and
/// a span 3 ns beside its two clock readings (20 ns in all): no system call, no lock, no page fault (on a
/// memory file system, see above). Threads that have called job() must have ended before it is destroyed.
class FlightRing {
 public:
  /// Makes the file whole as PATH.part and puts it at PATH, now or with take_place(). A ring that stands
  /// there from a run that did not end is kept as PATH.previous then; so is one that died with a job before
  /// it took its place. What else a killed start has left, a file without a word in it among that, is in
  /// nobody's way. Throws std::runtime_error (what, where, cure): a living run uses it, it is another's, it
  /// is no ring, no room; then everything is as it was.
  FlightRing(const std::string& path, const FlightPlan& plan);
  /// A ring that has not taken its place goes away.
  ~FlightRing();
  FlightRing(const FlightRing&) = delete;
  FlightRing& operator=(const FlightRing&) = delete;

  /// Says when the run begins: CLOCK_MONOTONIC at 0 of the run clock, and what makes it UTC. Before the first
  /// job: known only when everything else that takes time is done, the making of this file included.
  void set_clock(std::int64_t start_ns, std::int64_t utc_minus_monotonic_ns);

  /// Puts the file at PATH, where the run's first job is in it. Idempotent; not for real-time threads. Empty,
  /// or why that was refused, with the name under which the file can be found.
  std::string take_place();

  /// Notes a job that has run, and makes the group's track that of the calling thread. Real-time safe; a
  /// group's jobs come from one thread at a time.
  void job(const JobRecord& record) noexcept;
  /// Notes something in words; cut to kEventText bytes. Takes a lock: not for real-time threads.
  void event(Nanoseconds time_ns, Tick tick, std::string_view text);
  /// Track of a group's worker (its index) or of another thread (groups + its index). One thread each.
  SpanTrack& track(std::uint32_t index) { return tracks_[index]; }
  /// Where to say which task of a group is running: 1 + its index within the group, 0: none.
  std::atomic<std::uint32_t>* running(std::uint32_t group) noexcept;

  /// A fatal signal has come to the calling thread; the first one stays. Safe in a signal handler.
  void died(int signal, int code, const void* address) noexcept;
  /// The run has ended by itself, at `time_ns` of the run clock.
  void finish(Nanoseconds time_ns) noexcept;

  const std::string& path() const { return path_; }
  std::size_t bytes() const { return bytes_; }
  /// Empty, or what is not as it should be, with the cure: the file is on a disk; an older ring is kept.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void lay_out(const FlightPlan& plan, FlightHeader& header);  // `header`: a copy of the plan's
  void look_at_former();
  void rescue_part();
  void tell_kept();
  void map_file(const FlightHeader& header);

  std::string path_;
  std::unique_ptr<FilePlace> place_;
  bool former_unfinished_{};
  std::byte* map_{};
  std::size_t bytes_{};
  FlightState* state_{};
  FlightWriter jobs_[kMaxGroups];
  std::unique_ptr<SpanTrack[]> tracks_;
  std::mutex event_mutex_;
  FlightWriter events_;
  std::vector<std::string> warnings_;
};

}  // namespace sortie::rt::posix
