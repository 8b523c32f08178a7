// SPDX-License-Identifier: BSD-3-Clause
// From a processor's cycle counter to nanoseconds: a broken line, and the rule by which it is continued so
// that it follows a reference clock and never runs backwards, however late a reader or the writer is.
#pragma once

#include <cstdint>

#include "rt/time.hpp"

#ifdef __SIZEOF_INT128__
#define SORTIE_CLOCK_LINE 1
#else
#define SORTIE_CLOCK_LINE 0
#endif

#if SORTIE_CLOCK_LINE

namespace sortie::rt::posix {

/// A cycle count and the reference clock's time at the same moment.
struct ClockSample {
  std::uint64_t cycles{};
  Nanoseconds time_ns{};
};

/// Three straight pieces: slope `before` up to `start_cycles`, slope `after` for `span_cycles`, then
/// `slowest`. Slopes are nanoseconds per cycle times 2^48. `slowest` is the same for all lines of a clock and
/// no line is flatter anywhere: whoever still reads an old line cannot be ahead of one who reads a new one.
struct ClockLine {
  static constexpr int kShift = 48;
  __extension__ using Wide = __int128;

  std::uint64_t start_cycles{};
  Nanoseconds start_ns{};
  std::uint64_t start_fraction{};  ///< of a nanosecond, times 2^48: pieces join without a step by rounding
  std::int64_t before{};
  std::int64_t after{};
  std::int64_t slowest{};
  std::uint64_t span_cycles{};

  /// The first line through a sample. `slope`: measured; the clock will not run slower than 0.1 % below it.
  static ClockLine through(const ClockSample& sample, std::int64_t slope, std::uint64_t span_cycles) {
    return {sample.cycles, sample.time_ns, 0, slope, slope, slope - (slope >> 10), span_cycles};
  }
  std::uint64_t end_cycles() const { return start_cycles + span_cycles; }
  /// Time to continue this line: the middle of its second piece has passed, or the counter was set back.
  bool due(std::uint64_t cycles) const {
    const auto since = static_cast<std::int64_t>(cycles - start_cycles);
    const auto span = static_cast<std::int64_t>(span_cycles);
    return since >= span / 2 || since < -span;
  }

  /// Time [ns] at `cycles`, rounded down. About 2 ns.
  Nanoseconds at(std::uint64_t cycles) const {
    const auto since = static_cast<std::int64_t>(cycles - start_cycles);
    if (since > static_cast<std::int64_t>(span_cycles)) [[unlikely]]
      return static_cast<Nanoseconds>(exact(since) >> kShift);
    const Wide way = static_cast<Wide>(since) * (since < 0 ? before : after);
    return start_ns + static_cast<Nanoseconds>((way + static_cast<Wide>(start_fraction)) >> kShift);
  }

  /// The same with its fraction, times 2^48, for any piece.
  Wide exact(std::int64_t since) const {
    const auto span = static_cast<std::int64_t>(span_cycles);
    Wide way = (static_cast<Wide>(start_ns) << kShift) + static_cast<Wide>(start_fraction);
    if (since < 0) return way + static_cast<Wide>(since) * before;
    way += static_cast<Wide>(since < span ? since : span) * after;
    return since <= span ? way : way + static_cast<Wide>(since - span) * slowest;
  }
};

/// Mean slope between two samples, later.cycles > earlier.cycles.
inline std::int64_t clock_slope(const ClockSample& earlier, const ClockSample& later) {
  const auto way = static_cast<ClockLine::Wide>(later.time_ns - earlier.time_ns) << ClockLine::kShift;
  return static_cast<std::int64_t>(way / static_cast<ClockLine::Wide>(later.cycles - earlier.cycles));
}

/// A continued line.
struct ClockStep {
  ClockLine line;
  bool stepped_back{};  ///< the only way to run backwards: the machine slept while its counter went on
};

/// Continues a `line` that is due for another span so that it meets the reference clock at the end of that
/// span. `now`: a fresh sample. `slope`: of the reference clock, measured. Where the line has ended or is
/// wrong by more than 1 ms it is set to the reference at once; backwards only in the second case.
inline ClockStep continue_line(const ClockLine& line, const ClockSample& now, std::int64_t slope) {
  using Wide = ClockLine::Wide;
  constexpr Nanoseconds kWrong = kNanosecondsPerMillisecond;
  const auto since = static_cast<std::int64_t>(now.cycles - line.start_cycles);
  const auto span = static_cast<std::int64_t>(line.span_cycles);
  const Wide here = line.exact(since);
  const Nanoseconds ahead = static_cast<Nanoseconds>(here >> ClockLine::kShift) - now.time_ns;

  ClockStep step;
  ClockLine& next = step.line;
  next.span_cycles = line.span_cycles;
  next.slowest = line.slowest;
  Wide start = 0;
  if (since < span && ahead < kWrong && ahead > -kWrong) {  // in time: go on where the old line ends
    next.start_cycles = line.end_cycles();
    next.before = line.after;
    start = line.exact(span);
  } else {
    next.start_cycles = now.cycles;
    next.before = since < span ? line.after : line.slowest;
    start = static_cast<Wide>(now.time_ns) << ClockLine::kShift;
    step.stepped_back = ahead >= kWrong;
    if (here > start && !step.stepped_back) start = here;
  }
  next.start_ns = static_cast<Nanoseconds>(start >> ClockLine::kShift);
  next.start_fraction = static_cast<std::uint64_t>(start & ((Wide{1} << ClockLine::kShift) - 1));

  const auto to_end = static_cast<Wide>(next.start_cycles - now.cycles) + span;
  const Wide aim = (static_cast<Wide>(now.time_ns) << ClockLine::kShift) + to_end * slope;
  Wide after = (aim - start) / span;
  const Wide fastest = static_cast<Wide>(slope) + (slope >> 10);
  after = after > fastest ? fastest : after;
  next.after = static_cast<std::int64_t>(after < line.slowest ? line.slowest : after);
  return step;
}

}  // namespace sortie::rt::posix

#endif
