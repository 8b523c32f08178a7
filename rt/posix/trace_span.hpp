// SPDX-License-Identifier: BSD-3-Clause
// Stretches of a thread's time, named and kept in a ring: where inside a job did the time go?
//
//   const rt::posix::SpanName kMerge("merge");             // once, at set-up or as a global
//   ...
//   { const rt::posix::TraceSpan span(kMerge); merge(); }  // in a task
#pragma once

#include <cstdint>

#include "rt/posix/fast_clock.hpp"
#include "rt/posix/flight_format.hpp"

namespace sortie::rt::posix {

/// One writer's ring of spans. Without memory it drops what it is given.
class SpanTrack {
 public:
  SpanTrack() = default;
  /// `slots` entries of kSpanWords words from `first` on, a power of two.
  SpanTrack(std::uint32_t* first, std::uint32_t slots) : writer_{first, slots - 1, 0} {}

  /// Notes a span; CLOCK_MONOTONIC [ns]. Real-time safe, about 3 ns.
  void add(std::uint32_t name, Nanoseconds begin_ns, Nanoseconds end_ns) noexcept {
    if (writer_.first == nullptr) return;
    const auto begin = static_cast<std::uint64_t>(begin_ns);
    const auto length = static_cast<std::uint64_t>(end_ns > begin_ns ? end_ns - begin_ns : 0);
    const std::uint32_t words[kSpanWords - 2] = {
        static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(begin >> 32),
        length > 0xffffffffu ? 0xffffffffu : static_cast<std::uint32_t>(length), name};
    writer_.add(words);
  }

 private:
  FlightWriter writer_;
};

/// The track of the calling thread, or null. Set by whoever runs the thread.
inline thread_local SpanTrack* this_thread_spans = nullptr;

/// Index of a span's name; there is room for kMaxSpanNames in a program, later ones are called "other".
/// Equal names share an index. Names are taken into a ring when it is made: declare them before the run.
class SpanName {
 public:
  explicit SpanName(const char* name);
  std::uint32_t index() const { return index_; }

 private:
  std::uint32_t index_;
};

/// Names so far, and their number.
std::uint32_t span_name_count();
const char* span_name(std::uint32_t index);

/// Notes the time from its construction to its destruction on the thread's track. Two clock readings and a
/// few stores; two loads where the thread has no track.
class [[nodiscard]] TraceSpan {
 public:
  explicit TraceSpan(const SpanName& name) noexcept
      : track_(this_thread_spans), name_(name.index()), begin_ns_(track_ != nullptr ? fast_now() : 0) {}
  ~TraceSpan() {
    if (track_ != nullptr) track_->add(name_, begin_ns_, fast_now());
  }
  TraceSpan(const TraceSpan&) = delete;
  TraceSpan& operator=(const TraceSpan&) = delete;

 private:
  SpanTrack* track_;
  std::uint32_t name_;
  Nanoseconds begin_ns_;
};

}  // namespace sortie::rt::posix
