// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/replay_part.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "drivers/wire_cursor.hpp"
#include "firmware_like/log/keyframe_state.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/scene/input_error.hpp"

namespace sortie::firmware {
namespace {

// The tick of a place in a log as a person writes it: "12.5" (seconds after tick 0, rounded up to a whole
// tick) or "@12500" (a tick, as `check` names it). Throws InputError (exit code 2) that shows both forms.
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

}  // namespace

void choose_part(const LogFile& log, const ReplayOptions& options, ReplayOutcome& outcome, LogFeed& feed) {
  const rt::Nanoseconds tick_ns = outcome.runtime->executive().base_tick_ns();
  outcome.first_tick = outcome.begin_tick = feed.first_tick();
  const rt::Tick log_end = feed.last_tick() + 1;
  const rt::Tick end = options.to.empty() ? log_end : parse_log_time(options.to, tick_ns, "--to");
  if (!options.from.empty())
    outcome.first_tick = std::max(outcome.first_tick, parse_log_time(options.from, tick_ns, "--from"));
  if (outcome.first_tick >= std::min(end, log_end)) {
    throw InputError("nothing lies between --from (tick " + std::to_string(outcome.first_tick) +
                         ") and --to (tick " + std::to_string(end) + "); the log runs from tick " +
                         std::to_string(feed.first_tick()) + " to " + std::to_string(feed.last_tick()),
                     2);
  }
  feed.end_before(end);
  const bool named = !options.keyframes.empty();
  const std::string path = named ? options.keyframes : keyframe_path(log.path());
  if (options.from.empty() || (!named && !std::filesystem::exists(path))) return;
  if (!options.record.empty()) {
    throw InputError(
        "--record does not go with --from and keyframes: such a log would lack what its jobs took before", 2);
  }
  const KeyframeFile file(path);
  refuse_foreign(file, keyframe_head(log, *outcome.runtime), log.path());
  const KeyframeEntry* entry = file.nearest(outcome.first_tick);
  if (entry == nullptr || entry->tick <= feed.first_tick()) return;
  restore_state(file.state(*entry), *outcome.runtime, feed, entry->tick);
  outcome.begin_tick = outcome.restored_tick = entry->tick;
}

bool reads_ticks(const LogFile& log) {
  const auto& ticks = log.channel(std::string(drivers::kChannelTick));
  return ticks.empty() || drivers::fingerprint_of(ticks.front().message) == drivers::kFingerprintTick;
}

std::string why_not_comparable(const LogFile& log, const ReplayOptions& options, const Runtime& runtime) {
  const drivers::LogHeader& header = log.header();
  if (!header.has_ticks) return "an imported log has no recorded outputs";
  if (static_cast<std::uint64_t>(header.scene_hash) != runtime.profile().hash()) {
    return options.scene.empty() && options.overrides.empty()
               ? "the profile in the log is damaged: its hash differs"
               : "replayed with another profile than it was recorded with";
  }
  if (header.version != version()) return "recorded by version " + header.version + ", this is " + version();
  if (!reads_ticks(log)) return "its jobs are recorded in a message of another build of version " + version();
  if (header.groups != runtime.group_table()) {
    return "this build makes other groups of the same profile than the one that recorded it";
  }
  return {};
}

void refuse_unknown_vehicle(const LogFile& log, const VehicleRegistry& vehicles) {
  std::string known;
  for (const auto& [name, factory] : vehicles) {
    if (name == log.header().vehicle) return;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw InputError(log.path() + ": recorded by vehicle " + log.header().vehicle + ", which this program (" +
                       known + ") does not have; replay it with the program of that robot, or give --scene",
                   2);
}

}  // namespace sortie::firmware
