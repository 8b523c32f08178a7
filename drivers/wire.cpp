// SPDX-License-Identifier: BSD-3-Clause
// Codecs of the sample messages; member order as in drivers/messages/*.lcm.
#include "drivers/wire.hpp"

#include <limits>

#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

Status encode(const rt::ImuSample& sample, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintImu);
  writer.put(sample.stamp_ns);
  writer.put(seq);
  writer.put_array(sample.gyr_rad_s, 3);
  writer.put_array(sample.acc_m_s2, 3);
  writer.put(sample.flags);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::ImuSample& sample, std::int64_t& seq) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintImu); type != Status::ok) return type;
  if (message.size() != kImuBytes) return Status::malformed;
  sample.stamp_ns = reader.get<std::int64_t>();
  seq = reader.get<std::int64_t>();
  reader.get_array(sample.gyr_rad_s, 3);
  reader.get_array(sample.acc_m_s2, 3);
  sample.flags = reader.get<std::uint32_t>();
  return reader.finish();
}

Status encode(const rt::TrackSample& sample, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintTrack);
  writer.put(sample.stamp_ns);
  writer.put(seq);
  writer.put(sample.left_m);
  writer.put(sample.right_m);
  writer.put(sample.flags);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::TrackSample& sample, std::int64_t& seq) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintTrack); type != Status::ok) return type;
  if (message.size() != kTrackBytes) return Status::malformed;
  sample.stamp_ns = reader.get<std::int64_t>();
  seq = reader.get<std::int64_t>();
  sample.left_m = reader.get<double>();
  sample.right_m = reader.get<double>();
  sample.flags = reader.get<std::uint32_t>();
  return reader.finish();
}

Status encode(const rt::TruthSample& sample, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintTruth);
  writer.put(sample.stamp_ns);
  writer.put_array(sample.p_world_body_m, 3);
  writer.put_array(sample.q_world_body, 4);
  writer.put(sample.flags);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::TruthSample& sample) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintTruth); type != Status::ok) return type;
  if (message.size() != kTruthBytes) return Status::malformed;
  sample.stamp_ns = reader.get<std::int64_t>();
  reader.get_array(sample.p_world_body_m, 3);
  reader.get_array(sample.q_world_body, 4);
  sample.flags = reader.get<std::uint32_t>();
  return reader.finish();
}

Status encode(const CanFrame& frame, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintCan);
  writer.put(frame.stamp_ns);
  writer.put(frame.id);
  writer.put(frame.size);
  writer.put(frame.flags);
  writer.put_array(frame.data, 8);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, CanFrame& frame) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintCan); type != Status::ok) return type;
  CanFrame read;
  read.stamp_ns = reader.get<std::int64_t>();
  read.id = reader.get<std::uint32_t>();
  read.size = reader.get<std::uint8_t>();
  read.flags = reader.get<std::uint8_t>();
  reader.get_array(read.data, 8);
  if (reader.finish() != Status::ok || read.size > 8) return Status::malformed;
  frame = read;
  return Status::ok;
}

Status encode(const rt::PointScan& scan, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  size = 0;
  const rt::ScanHeader& head = scan.header;
  const std::size_t count = head.points;
  if (count > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / kScanPointBytes)
    return Status::full;
  WireWriter writer(out);
  writer.put(kFingerprintScan);
  writer.put(head.stamp_ns);
  writer.put(seq);
  writer.put(head.flags);
  writer.put_array(head.p_world_sensor_m, 3);
  writer.put_array(head.q_world_sensor, 4);
  writer.put_count(count);
  for (std::size_t i = 0; i < count; ++i) {
    writer.put(scan.points[i].x_m);
    writer.put(scan.points[i].y_m);
    writer.put(scan.points[i].z_m);
  }
  for (std::size_t i = 0; i < count; ++i) writer.put(scan.points[i].intensity);
  for (std::size_t i = 0; i < count; ++i) writer.put(scan.points[i].age_10us);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::ScanHeader& header, std::span<rt::ScanPoint> points,
              std::int64_t& seq) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintScan); type != Status::ok) return type;
  rt::ScanHeader read;
  read.stamp_ns = reader.get<std::int64_t>();
  const auto number = reader.get<std::int64_t>();
  read.flags = reader.get<std::uint32_t>();
  reader.get_array(read.p_world_sensor_m, 3);
  reader.get_array(read.q_world_sensor, 4);
  const std::size_t count = reader.get_count(kScanPointBytes);
  if (reader.status() != Status::ok || reader.left() != count * kScanPointBytes) return Status::malformed;
  read.points = static_cast<std::uint32_t>(count);
  header = read;
  seq = number;
  if (count > points.size()) return Status::full;
  for (std::size_t i = 0; i < count; ++i) {
    points[i].x_m = reader.get<float>();
    points[i].y_m = reader.get<float>();
    points[i].z_m = reader.get<float>();
  }
  for (std::size_t i = 0; i < count; ++i) points[i].intensity = reader.get<std::uint16_t>();
  for (std::size_t i = 0; i < count; ++i) points[i].age_10us = reader.get<std::uint16_t>();
  return reader.finish();
}

}  // namespace sortie::drivers
