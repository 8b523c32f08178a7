// SPDX-License-Identifier: BSD-3-Clause
// What ran when, as Chrome trace JSON: opens in ui.perfetto.dev, chrome://tracing and speedscope.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sortie::toolchain {

/// One stretch of time on one track.
struct TraceSpan {
  std::string name;
  int track{};  ///< usually the group
  std::int64_t start_ns{};
  std::int64_t duration_ns{};
  std::vector<std::pair<std::string, std::string>> details;  ///< shown when the span is clicked
};

/// Something that happened at one moment, shown across all tracks.
struct TraceMark {
  std::string text;
  std::int64_t time_ns{};
};

/// Name of a track; tracks are shown in the order of their numbers.
struct TraceTrack {
  int track{};
  std::string name;
};

/// A whole trace.
struct Trace {
  std::string process{"sortie"};
  std::vector<TraceTrack> tracks;
  std::vector<TraceSpan> spans;
  std::vector<TraceMark> marks;
};

/// Writes the trace; times become microseconds with three decimals, counted from `epoch_ns` (viewers keep
/// doubles). Spans of one track must nest: a span that would reach out of the one around it is cut to that
/// one's end, and the number of such cuts is returned.
std::size_t write_chrome_trace(std::ostream& out, const Trace& trace, std::int64_t epoch_ns = 0);

}  // namespace sortie::toolchain
