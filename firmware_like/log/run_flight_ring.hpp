// SPDX-License-Identifier: BSD-3-Clause
// The flight ring of a run: where its file lies, what it is told, and what a run before has left.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware_like/runtime/runtime.hpp"
#include "rt/posix/crash_note.hpp"
#include "rt/posix/flight_ring.hpp"

namespace sortie::firmware {

/// What was asked for.
struct FlightRingOptions {
  /// A file; "none": no ring; "auto": in memory (XDG_RUNTIME_DIR or /dev/shm) for live runs, removed again
  /// when the run ends by itself; none in simulated time, which can be repeated.
  std::string path{"auto"};
  std::uint32_t ticks{10'000};  ///< kept at least
};

/// A ring, or nothing: then every call does nothing.
class RunFlightRing {
 public:
  /// Throws std::runtime_error when a file that was asked for cannot be had; "auto" turns that into a
  /// warning.
  RunFlightRing(Runtime& runtime, const FlightRingOptions& options, bool simulated_time);
  /// A file that nobody asked for by name goes away.
  ~RunFlightRing();
  RunFlightRing(const RunFlightRing&) = delete;
  RunFlightRing& operator=(const RunFlightRing&) = delete;

  /// When the run begins: CLOCK_MONOTONIC at 0 of the run clock, and what makes it UTC. Before the first job.
  void set_clock(rt::Nanoseconds start_ns, rt::Nanoseconds utc_minus_monotonic_ns);
  /// The run has its first job: from now on the file is found under its name. Cheap afterwards; not for
  /// real-time threads.
  void first_job();
  /// A sink that notes each job and hands it on to `next`. Lives as long as this object.
  rt::JobSink before(rt::JobSink next);
  /// Notes something in words. Not for real-time threads.
  void event(rt::Nanoseconds time_ns, rt::Tick tick, std::string_view text);
  /// Keeps the calling thread's spans on the track "devices" or "bench"; other names have none.
  void adopt_thread(std::string_view name);
  /// The run has ended by itself.
  void finish(rt::Nanoseconds time_ns);

  /// True when there is a ring whose file was asked for by name, and it holds a job.
  bool stays() const { return ring_ && !own_file_ && in_place_; }
  /// Empty without a ring.
  std::string path() const { return ring_ ? ring_->path() : std::string(); }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Empty, or why first_job() could not put the file into its place and where it is.
  const std::string& place_problem() const { return place_problem_; }
  /// How the run before ended, if that was not by itself and its ring is still there; else empty.
  const std::string& before_this() const { return before_this_; }

 private:
  Runtime& runtime_;
  std::unique_ptr<rt::posix::FlightRing> ring_;
  std::vector<std::atomic<std::uint32_t>*> running_before_;
  rt::JobSink next_{};
  bool own_file_{};
  bool in_place_{};
  std::string place_problem_;
  std::vector<std::string> warnings_;
  std::string before_this_;
  std::unique_ptr<rt::posix::CrashNote> crash_;  // last: it stops pointing at the ring before the ring goes
};

/// Rings in `folder` that runs of this user have left there without ending, newest first.
std::vector<std::string> unfinished_flight_rings(const std::string& folder);

}  // namespace sortie::firmware
