// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/log_time.hpp"

#include <charconv>
#include <cmath>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::firmware {

rt::Tick parse_log_time(const std::string& text, rt::Nanoseconds base_tick_ns, const std::string& option) {
  const char* end = text.data() + text.size();
  if (!text.empty() && text[0] == '@') {
    rt::Tick tick{};
    const auto result = std::from_chars(text.data() + 1, end, tick);
    if (result.ec == std::errc{} && result.ptr == end) return tick;
  } else {
    double seconds{};
    const auto result = std::from_chars(text.data(), end, seconds);
    constexpr double kMost_s = 1e9;  // 30 years: far from the range of ticks
    if (result.ec == std::errc{} && result.ptr == end && seconds >= 0 && seconds <= kMost_s) {
      // A little less than the next whole number: 0.3 s shall be tick 300, not 301.
      return static_cast<rt::Tick>(std::ceil(seconds * 1e9 / static_cast<double>(base_tick_ns) - 1e-6));
    }
  }
  throw InputError(
      option + " " + text + ": write seconds since the start of the log, e.g. 12.5, or a tick, e.g. @12500",
      2);
}

}  // namespace sortie::firmware
