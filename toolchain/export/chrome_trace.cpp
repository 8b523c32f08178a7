// SPDX-License-Identifier: BSD-3-Clause
// The JSON Array Format of the trace event specification: "X" spans, "i" marks, "M" names.
#include "toolchain/export/chrome_trace.hpp"

#include <algorithm>
#include <ostream>

#include "firmware_like/scene/json.hpp"

namespace sortie::toolchain {
namespace {

std::string quoted(const std::string& text) { return firmware::Json(text).dump(); }

/// Nanoseconds as microseconds, exact.
std::string microseconds(std::int64_t ns) {
  const std::uint64_t size = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  const std::string fraction = std::to_string(size % 1000u);
  return (ns < 0 ? "-" : "") + std::to_string(size / 1000u) + "." + std::string(3 - fraction.size(), '0') +
         fraction;
}

struct Placed {
  const TraceSpan* span;
  std::int64_t end_ns;
};

/// Spans by track and start, the longer first, each cut to the one around it.
std::vector<Placed> nest(const std::vector<TraceSpan>& spans, std::size_t& cuts) {
  std::vector<Placed> placed;
  placed.reserve(spans.size());
  for (const TraceSpan& span : spans)
    placed.push_back({&span, span.start_ns + std::max<std::int64_t>(span.duration_ns, 0)});
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    if (a.span->track != b.span->track) return a.span->track < b.span->track;
    if (a.span->start_ns != b.span->start_ns) return a.span->start_ns < b.span->start_ns;
    return a.end_ns > b.end_ns;
  });
  std::vector<std::int64_t> open;  // ends of the spans around, innermost last
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (i > 0 && placed[i].span->track != placed[i - 1].span->track) open.clear();
    while (!open.empty() && open.back() <= placed[i].span->start_ns) open.pop_back();
    if (!open.empty() && placed[i].end_ns > open.back()) {
      placed[i].end_ns = open.back();
      ++cuts;
    }
    open.push_back(placed[i].end_ns);
  }
  return placed;
}

}  // namespace

std::size_t write_chrome_trace(std::ostream& out, const Trace& trace, std::int64_t epoch_ns) {
  const char* separator = "\n";
  const auto next = [&]() -> std::ostream& {
    out << separator;
    separator = ",\n";
    return out;
  };
  out << "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[";
  next() << R"({"ph":"M","pid":1,"tid":0,"name":"process_name","args":{"name":)" << quoted(trace.process)
         << "}}";
  for (const TraceTrack& track : trace.tracks) {
    const std::string tid = std::to_string(track.track);
    next() << R"({"ph":"M","pid":1,"tid":)" << tid << R"(,"name":"thread_name","args":{"name":)"
           << quoted(track.name) << "}}";
    next() << R"({"ph":"M","pid":1,"tid":)" << tid << R"(,"name":"thread_sort_index","args":{"sort_index":)"
           << tid << "}}";
  }
  std::size_t cuts = 0;
  for (const Placed& placed : nest(trace.spans, cuts)) {
    const TraceSpan& span = *placed.span;
    next() << R"({"ph":"X","pid":1,"tid":)" << std::to_string(span.track) << R"(,"name":)"
           << quoted(span.name) << R"(,"ts":)" << microseconds(span.start_ns - epoch_ns) << R"(,"dur":)"
           << microseconds(placed.end_ns - span.start_ns);
    if (!span.details.empty()) {
      out << R"(,"args":{)";
      for (std::size_t i = 0; i < span.details.size(); ++i) {
        out << (i > 0 ? "," : "") << quoted(span.details[i].first) << ':' << quoted(span.details[i].second);
      }
      out << '}';
    }
    out << '}';
  }
  for (const TraceMark& mark : trace.marks) {
    next() << R"({"ph":"i","s":"g","pid":1,"tid":0,"name":)" << quoted(mark.text) << R"(,"ts":)"
           << microseconds(mark.time_ns - epoch_ns) << "}";
  }
  out << "\n]}\n";
  return cuts;
}

}  // namespace sortie::toolchain
