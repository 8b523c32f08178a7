// SPDX-License-Identifier: BSD-3-Clause
// The records of a log that are not samples (header, tick, gap, user samples) and telemetry (fields,
// statistics, pose): plain structs, to message bytes and back.
//
// For threads that are not real-time: decoders allocate, but never more than the message is long. Encoders do
// not allocate; they give `full` if `out` is too small and then leave `size` at 0. Decoders give
// `bad_checksum` for a message of another type and `malformed` for wrong lengths; the outputs may then be
// half filled.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/channels.hpp"
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
};

/// Samples of one input stream that a job consumed: first_seq .. first_seq + count - 1.
struct StreamTake {
  std::int16_t stream_id{};
  std::int64_t first_seq{};
  std::int32_t count{};
};

/// Jobs of another group whose outputs a job saw.
struct ChannelTake {
  std::int64_t first{};
  std::int64_t last{};
};

/// What one task gave out in this job.
struct TaskOutput {
  std::uint64_t digest{};
  std::int32_t units{};
};

/// A tick record for encoding: views of someone else's memory.
struct TickView {
  std::int64_t tick{};
  std::int64_t job{};
  std::int32_t group{};
  std::int8_t verdict{};
  std::int8_t level{};  ///< of the degrade ladder
  std::int16_t shed{};  ///< bit i: task i was left out
  std::int16_t cut{};   ///< bit i: the clock stopped task i
  std::span<const StreamTake> streams;
  std::span<const ChannelTake> channels;
  std::span<const TaskOutput> tasks;
  std::span<const std::uint8_t> fields;  ///< canonical outputs, or empty
};

/// A tick record as read back. Reuse one object: its vectors keep their memory.
struct TickRecord {
  std::int64_t tick{};
  std::int64_t job{};
  std::int32_t group{};
  std::int8_t verdict{};
  std::int8_t level{};
  std::int16_t shed{};
  std::int16_t cut{};
  std::vector<StreamTake> streams;
  std::vector<ChannelTake> channels;
  std::vector<TaskOutput> tasks;
  std::vector<std::uint8_t> fields;

  /// The same as views; lives as long as this record is not changed.
  [[nodiscard]] TickView view() const {
    return {tick, job, group, verdict, level, shed, cut, streams, channels, tasks, fields};
  }
};

/// Something that a user wants to know when it happens: a step of the degrade ladder, a stuck task, a broken
/// promise.
struct EventRecord {
  std::int64_t utime{};  ///< microseconds, of the log's or the wall clock
  std::int64_t tick{};
  std::string kind;     ///< "ladder", "stuck", "unstuck", "promise", "stop", ...
  std::string subject;  ///< a group, a task or a core
  std::int64_t value{};
  std::string text;  ///< one sentence
};

/// The recorder lost events here.
struct GapRecord {
  std::int64_t tick{};
  std::int32_t group{};
  std::int64_t lost{};
  std::string reason;
};

/// A sample of a user's own type. On decoding the views point into the message.
struct CustomView {
  std::string_view type;
  std::int64_t stamp_ns{};
  std::int64_t seq{};
  std::string_view fields;             ///< "name:type,..." in declaration order
  std::span<const std::uint8_t> data;  ///< canonical form
};

/// bot_core.pose_t: utime in us, position and velocity in the world, rate and acceleration in the body.
struct PoseMessage {
  std::int64_t utime{};
  double pos[3]{};
  double vel[3]{};
  double orientation[4]{1, 0, 0, 0};
  double rotation_rate[3]{};
  double accel[3]{};
};

/// Message bytes of the record; `size` becomes the message size.
[[nodiscard]] Status encode(const LogHeader& header, std::span<std::uint8_t> out, std::size_t& size) noexcept;
[[nodiscard]] Status encode(const TickView& tick, std::span<std::uint8_t> out, std::size_t& size) noexcept;
[[nodiscard]] Status encode(const GapRecord& gap, std::span<std::uint8_t> out, std::size_t& size) noexcept;
[[nodiscard]] Status encode(const EventRecord& event, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status encode(const CustomView& sample, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status encode(const PoseMessage& pose, std::span<std::uint8_t> out, std::size_t& size) noexcept;

/// Record from message bytes.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, LogHeader& header);
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, TickRecord& tick);
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, GapRecord& gap);
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, EventRecord& event);
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, CustomView& sample) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, PoseMessage& pose) noexcept;

/// Bytes that encode() will need.
[[nodiscard]] std::size_t encoded_bytes(const LogHeader& header) noexcept;
[[nodiscard]] std::size_t encoded_bytes(const TickView& tick) noexcept;

/// The pose message of an estimate: body velocity turned into the world, acceleration 0 (not estimated).
[[nodiscard]] PoseMessage to_pose_message(const rt::PoseEstimate& estimate, std::int64_t utime) noexcept;

}  // namespace sortie::drivers
