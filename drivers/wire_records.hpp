// SPDX-License-Identifier: BSD-3-Clause
// The records of a log that are not samples (header, tick, timing, event, gap, user samples), and the pose:
// plain structs, to message bytes and back.
//
// encode() and decode() are those of wire_fields.hpp. Records with texts and vectors are for threads that are
// not real-time: their decoders allocate, but never more than the message is long.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/channels.hpp"
#include "drivers/wire_fields.hpp"
#include "rt/describe.hpp"
#include "rt/job_record.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// First event of a log; the members of header_t.lcm. Strings must not contain zero bytes.
struct LogHeader {
  std::string version;
  std::string compiler;
  std::string vehicle;
  std::string scene;
  std::string scene_toml;
  std::int64_t scene_hash{};
  std::int64_t base_tick_ns{};
  std::int64_t epoch_ns{};
  std::int64_t utc_minus_monotonic_ns{};
  bool has_ticks{};
  double initial_p[3]{};
  double initial_q[4]{1, 0, 0, 0};
  std::string groups;
  std::string tasks;
  std::string source;
  SORTIE_FIELDS(version, compiler, vehicle, scene, scene_toml, scene_hash, base_tick_ns, epoch_ns,
                utc_minus_monotonic_ns, has_ticks, initial_p, initial_q, groups, tasks, source)
};

/// In tick_t: samples first_seq .. first_seq + count - 1 of an input stream that a job consumed.
template <>
struct WireRules<rt::StreamRange> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("stream_id", self.stream);
    visit("first_seq", self.first);
    visit("count", self.count);
  }
};
/// In tick_t: jobs of another group whose outputs a job saw.
template <>
struct WireRules<rt::InputRange> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("taken_first", self.first);
    visit("taken_last", self.last);
  }
};
/// tick_t: a job without its times. What is read may be no job of any table: only the counts are sure to fit.
template <>
struct WireRules<rt::JobRecord> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    const auto used = [](const char* count_name, auto& array, auto& count) {
      return counted(count_name, std::span(array), count, Status::malformed);
    };
    visit("tick", self.tick);
    visit("job", self.job);
    visit("group", widened<std::int32_t>(self.group));
    visit("verdict", self.verdict);
    visit("level", self.level);
    visit("shed", self.shed);
    visit("cut", self.cut);
    visit("nstreams", widened<std::int32_t>(self.streams));
    visit("stream", used("nstreams", self.stream, self.streams));
    visit("nchannels", widened<std::int32_t>(self.inputs));
    visit("input", used("nchannels", self.input, self.inputs));
    visit("ntasks", widened<std::int32_t>(self.tasks));
    visit("digest", used("ntasks", self.digest, self.tasks));
    visit("units", used("ntasks", self.units, self.tasks));
    visit("nfields", self.field_bytes);
    visit("fields", used("nfields", self.fields, self.field_bytes));
  }
};

/// timing_t: when a job began, on the run's clock, and how long each of its tasks took.
template <class Durations>
struct TimingOf {
  std::int64_t tick{};
  std::int32_t group{};
  std::int64_t started_ns{};
  Durations duration_ns;
};
template <class Durations>
struct WireRules<TimingOf<Durations>> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("tick", self.tick);
    visit("group", self.group);
    visit("started_ns", self.started_ns);
    visit("duration_ns", listed<std::int64_t>("ntasks", self.duration_ns));
  }
};
using JobTiming = TimingOf<std::span<const std::uint32_t>>;
/// As read back.
using JobTimingRecord = TimingOf<std::vector<std::int64_t>>;

/// Something that a user wants to know when it happens: a step of the degrade ladder, a stuck task, a broken
/// promise.
struct EventRecord {
  std::int64_t utime{};  ///< microseconds, of the log's or the wall clock
  std::int64_t tick{};
  std::string kind;     ///< "ladder", "stuck", "unstuck", "promise", "stop", ...
  std::string subject;  ///< a group, a task or a core
  std::int64_t value{};
  std::string text;  ///< one sentence
  SORTIE_FIELDS(utime, tick, kind, subject, value, text)
};

/// The recorder lost events here.
struct GapRecord {
  std::int64_t tick{};
  std::int32_t group{};
  std::int64_t lost{};
  std::string reason;
  SORTIE_FIELDS(tick, group, lost, reason)
};

/// A sample of a user's own type. On decoding the views point into the message.
struct CustomView {
  std::string_view type;
  std::int64_t stamp_ns{};
  std::int64_t seq{};
  std::string_view fields;             ///< "name:type,..." in declaration order
  std::span<const std::uint8_t> data;  ///< canonical form
};
template <>
struct WireRules<CustomView> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("type", self.type);
    visit("stamp_ns", self.stamp_ns);
    visit("seq", self.seq);
    visit("fields", self.fields);
    visit("data", listed("n", self.data));
  }
};

/// bot_core.pose_t: utime in us, position and velocity in the world, rate and acceleration in the body.
struct PoseMessage {
  std::int64_t utime{};
  double pos[3]{};
  double vel[3]{};
  double orientation[4]{1, 0, 0, 0};
  double rotation_rate[3]{};
  double accel[3]{};
  SORTIE_FIELDS(utime, pos, vel, orientation, rotation_rate, accel)
};

/// In place, since a record is large: it may be half filled unless ok.
[[nodiscard]] inline Status decode(std::span<const std::uint8_t> message, rt::JobRecord& record) {
  std::int64_t none = 0;
  return detail::read_any(message, record, none);
}

/// The pose message of an estimate: body velocity turned into the world, acceleration 0 (not estimated).
[[nodiscard]] PoseMessage to_pose_message(const rt::PoseEstimate& estimate, std::int64_t utime) noexcept;

}  // namespace sortie::drivers
