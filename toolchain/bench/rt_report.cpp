// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::string noise_line(const firmware::Json& noise, const char* when) {
  if (!noise.contains(when)) return {};
  const firmware::Json& one = noise[when];
  const auto value = [&one](const char* key) { return firmware::format_short(one.value(key, 0.0)); };
  return std::string(when) + ": " + value("gaps_per_s") + " gaps above 2 us a second, p50 " +
         value("p50_us") + ", p99 " + value("p99_us") + ", max " + value("max_us") + " us; " +
         value("lost_percent") + " % of the time";
}

std::vector<std::string> rt_conditions(const firmware::Json& result) {
  const firmware::Json s = result.value("settings", firmware::Json::object());
  std::vector<std::string> lines{
      settings_line(result, std::to_string(s.value("rounds", 0)) + " rounds, slices of " +
                                firmware::format_short(s.value("slice_s", 0.0)) + " s, core " +
                                std::to_string(s.value("core", 0)) + ", " +
                                std::to_string(s.value("load", 0)) + " busy processes beside, " +
                                (s.value("realtime", false) ? "SCHED_FIFO" : "ordinary scheduling"))};
  for (const char* when : {"before", "after"}) {
    if (const std::string line = noise_line(result.value("noise", firmware::Json::object()), when);
        !line.empty())
      lines.push_back("noise     " + line);
  }
  return lines;
}

}  // namespace

PeerFront rt_front() {
  PeerFront front;
  front.name = "rt";
  front.file = "bench-rt";
  front.about = "The real-time ground beside cyclictest and boost: wake-ups, queues, executive, system calls";
  front.footer =
      "Ours and the peers' slices alternate, so ratios hold on a busy machine, too. docs/timing.md tells how "
      "to read it.\n"
      "Examples:\n"
      "  sortie bench rt\n"
      "  sortie bench rt --load 4 --core 1 --out out/loaded\n"
      "  sortie bench rt --only wake --rounds 5760 --slice 5     # 24 hours";
  front.options = {{"--rounds", 11, "Rounds of every part; each holds a slice of every peer", 1, 1000000},
                   {"--slice", 1.0, "Seconds of one slice of wake-ups", 0.05, 3600},
                   {"--core",
                    std::optional<std::uint64_t>(),
                    "The core to measure; the last one unless said",
                    0,
                    4095,
                    {},
                    "N"},
                   {"--load", 0, "Busy ordinary processes beside the wake-ups", 0, 1024},
                   choice("--only", "One part alone",
                          {"wake", "queue", "count", "mailbox", "executive", "calls", "cause", "load"})};
  front.all_timed = true;
  front.title = "The real-time ground beside its peers";
  front.intro =
      "Every figure and its peer's come from alternating slices of the same run: **the ratios travel, "
      "absolute times "
      "do not**. Figures are medians of the rounds (of all samples for wake-ups and mailboxes), in brackets "
      "the range "
      "over the rounds. How to read them: [timing](../timing.md).";
  front.conditions = rt_conditions;
  front.pictures = rt_pictures;
  return front;
}

}  // namespace sortie::toolchain
