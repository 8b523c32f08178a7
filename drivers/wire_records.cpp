// SPDX-License-Identifier: BSD-3-Clause
// Codecs of the log's records; member order as in drivers/messages/*.lcm.
#include "drivers/wire_records.hpp"

#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

Status encode(const LogHeader& header, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintHeader);
  writer.put_string(header.version);
  writer.put_string(header.compiler);
  writer.put_string(header.vehicle);
  writer.put_string(header.scene);
  writer.put_string(header.scene_toml);
  writer.put(header.scene_hash);
  writer.put(header.base_tick_ns);
  writer.put(header.epoch_ns);
  writer.put(header.utc_minus_monotonic_ns);
  writer.put(static_cast<std::int8_t>(header.has_ticks ? 1 : 0));
  writer.put_array(header.initial_p, 3);
  writer.put_array(header.initial_q, 4);
  writer.put_string(header.groups);
  writer.put_string(header.tasks);
  writer.put_string(header.source);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, LogHeader& header) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintHeader); type != Status::ok) return type;
  for (std::string* text :
       {&header.version, &header.compiler, &header.vehicle, &header.scene, &header.scene_toml}) {
    *text = reader.get_string();
  }
  header.scene_hash = reader.get<std::int64_t>();
  header.base_tick_ns = reader.get<std::int64_t>();
  header.epoch_ns = reader.get<std::int64_t>();
  header.utc_minus_monotonic_ns = reader.get<std::int64_t>();
  header.has_ticks = reader.get<std::int8_t>() != 0;
  reader.get_array(header.initial_p, 3);
  reader.get_array(header.initial_q, 4);
  for (std::string* text : {&header.groups, &header.tasks, &header.source}) *text = reader.get_string();
  return reader.finish();
}

std::size_t encoded_bytes(const LogHeader& header) noexcept {
  constexpr std::size_t kFixed = 8 + 4 * 8 + 1 + 7 * 8;
  std::size_t bytes = kFixed;
  for (const std::string* text : {&header.version, &header.compiler, &header.vehicle, &header.scene,
                                  &header.scene_toml, &header.groups, &header.tasks, &header.source}) {
    bytes += 4 + text->size() + 1;
  }
  return bytes;
}

Status encode(const TickView& tick, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  size = 0;
  if (encoded_bytes(tick) > out.size()) return Status::full;
  WireWriter writer(out);
  writer.put(kFingerprintTick);
  writer.put(tick.tick);
  writer.put(tick.job);
  writer.put(tick.group);
  writer.put(tick.verdict);
  writer.put(tick.level);
  writer.put(tick.shed);
  writer.put(tick.cut);
  writer.put_count(tick.streams.size());
  for (const StreamTake& take : tick.streams) writer.put(take.stream_id);
  for (const StreamTake& take : tick.streams) writer.put(take.first_seq);
  for (const StreamTake& take : tick.streams) writer.put(take.count);
  writer.put_count(tick.channels.size());
  for (const ChannelTake& take : tick.channels) writer.put(take.first);
  for (const ChannelTake& take : tick.channels) writer.put(take.last);
  writer.put_count(tick.tasks.size());
  for (const TaskOutput& task : tick.tasks) writer.put(task.digest);
  for (const TaskOutput& task : tick.tasks) writer.put(task.units);
  writer.put_count(tick.fields.size());
  writer.put_array(tick.fields.data(), tick.fields.size());
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, TickRecord& tick) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintTick); type != Status::ok) return type;
  tick.tick = reader.get<std::int64_t>();
  tick.job = reader.get<std::int64_t>();
  tick.group = reader.get<std::int32_t>();
  tick.verdict = reader.get<std::int8_t>();
  tick.level = reader.get<std::int8_t>();
  tick.shed = reader.get<std::int16_t>();
  tick.cut = reader.get<std::int16_t>();
  tick.streams.resize(reader.get_count(2 + 8 + 4));
  for (StreamTake& take : tick.streams) take.stream_id = reader.get<std::int16_t>();
  for (StreamTake& take : tick.streams) take.first_seq = reader.get<std::int64_t>();
  for (StreamTake& take : tick.streams) take.count = reader.get<std::int32_t>();
  tick.channels.resize(reader.get_count(8 + 8));
  for (ChannelTake& take : tick.channels) take.first = reader.get<std::int64_t>();
  for (ChannelTake& take : tick.channels) take.last = reader.get<std::int64_t>();
  tick.tasks.resize(reader.get_count(8 + 4));
  for (TaskOutput& task : tick.tasks) task.digest = reader.get<std::uint64_t>();
  for (TaskOutput& task : tick.tasks) task.units = reader.get<std::int32_t>();
  const auto fields = reader.get_bytes(reader.get_count(1));
  tick.fields.assign(fields.begin(), fields.end());
  return reader.finish();
}

std::size_t encoded_bytes(const TickView& tick) noexcept {
  constexpr std::size_t kFixed = 8 + 8 + 8 + 4 + 1 + 1 + 2 + 2 + 4 * 4;
  return kFixed + tick.streams.size() * 14 + tick.channels.size() * 16 + tick.tasks.size() * 12 +
         tick.fields.size();
}

Status encode(const GapRecord& gap, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintGap);
  writer.put(gap.tick);
  writer.put(gap.group);
  writer.put(gap.lost);
  writer.put_string(gap.reason);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, GapRecord& gap) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintGap); type != Status::ok) return type;
  gap.tick = reader.get<std::int64_t>();
  gap.group = reader.get<std::int32_t>();
  gap.lost = reader.get<std::int64_t>();
  gap.reason = reader.get_string();
  return reader.finish();
}

Status encode(const EventRecord& event, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintEvent);
  writer.put(event.utime);
  writer.put(event.tick);
  writer.put_string(event.kind);
  writer.put_string(event.subject);
  writer.put(event.value);
  writer.put_string(event.text);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, EventRecord& event) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintEvent); type != Status::ok) return type;
  event.utime = reader.get<std::int64_t>();
  event.tick = reader.get<std::int64_t>();
  event.kind = reader.get_string();
  event.subject = reader.get_string();
  event.value = reader.get<std::int64_t>();
  event.text = reader.get_string();
  return reader.finish();
}

Status encode(const CustomView& sample, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintCustom);
  writer.put_string(sample.type);
  writer.put(sample.stamp_ns);
  writer.put(sample.seq);
  writer.put_string(sample.fields);
  writer.put_count(sample.data.size());
  writer.put_array(sample.data.data(), sample.data.size());
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, CustomView& sample) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintCustom); type != Status::ok) return type;
  sample.type = reader.get_string();
  sample.stamp_ns = reader.get<std::int64_t>();
  sample.seq = reader.get<std::int64_t>();
  sample.fields = reader.get_string();
  sample.data = reader.get_bytes(reader.get_count(1));
  return reader.finish();
}

Status encode(const PoseMessage& pose, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintPose);
  writer.put(pose.utime);
  writer.put_array(pose.pos, 3);
  writer.put_array(pose.vel, 3);
  writer.put_array(pose.orientation, 4);
  writer.put_array(pose.rotation_rate, 3);
  writer.put_array(pose.accel, 3);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, PoseMessage& pose) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintPose); type != Status::ok) return type;
  pose.utime = reader.get<std::int64_t>();
  reader.get_array(pose.pos, 3);
  reader.get_array(pose.vel, 3);
  reader.get_array(pose.orientation, 4);
  reader.get_array(pose.rotation_rate, 3);
  reader.get_array(pose.accel, 3);
  return reader.finish();
}

PoseMessage to_pose_message(const rt::PoseEstimate& estimate, std::int64_t utime) noexcept {
  PoseMessage pose;
  pose.utime = utime;
  const double* q = estimate.q_world_body;
  const double* v = estimate.v_body_m_s;
  // v + 2 w (u x v) + 2 u x (u x v), with u the vector part of q.
  const double t[3] = {2 * (q[2] * v[2] - q[3] * v[1]), 2 * (q[3] * v[0] - q[1] * v[2]),
                       2 * (q[1] * v[1] - q[2] * v[0])};
  pose.vel[0] = v[0] + q[0] * t[0] + (q[2] * t[2] - q[3] * t[1]);
  pose.vel[1] = v[1] + q[0] * t[1] + (q[3] * t[0] - q[1] * t[2]);
  pose.vel[2] = v[2] + q[0] * t[2] + (q[1] * t[1] - q[2] * t[0]);
  for (int i = 0; i < 3; ++i) pose.pos[i] = estimate.p_world_body_m[i];
  for (int i = 0; i < 4; ++i) pose.orientation[i] = q[i];
  for (int i = 0; i < 3; ++i) pose.rotation_rate[i] = estimate.w_body_rad_s[i];
  return pose;
}

}  // namespace sortie::drivers
