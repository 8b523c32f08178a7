// SPDX-License-Identifier: BSD-3-Clause
// What codecs do that does not follow from the members of a struct alone.
#include "drivers/wire.hpp"

#include "drivers/wire_records.hpp"
#include "drivers/wire_segments.hpp"
#include "drivers/wire_truth.hpp"
#include "rt/fields.hpp"

namespace sortie::drivers {

Status decode(std::span<const std::uint8_t> message, rt::ScanHeader& header, std::span<rt::ScanPoint> points,
              std::int64_t& seq) noexcept {
  detail::WireIn stream{WireReader(message)};
  if (const Status type = expect_fingerprint(stream.reader, kFingerprintScan); type != Status::ok)
    return type;
  rt::ScanHeader read;
  std::int64_t number = 0;
  detail::walk_message(stream, read, number);
  const std::size_t left = stream.reader.left();
  if (stream.reader.status() != Status::ok || left % kScanPointBytes != 0 ||
      left / kScanPointBytes != read.points)
    return Status::malformed;
  header = read;
  seq = number;
  if (read.points > points.size()) return Status::full;
  detail::walk_elements<rt::ScanPoint, detail::AllMembers>(stream, points.first(read.points));
  return stream.reader.finish();
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

Status decode(std::span<const std::uint8_t> message, rt::SegmentList& list, std::int64_t& seq) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintSegments); type != Status::ok) return type;
  static_cast<void>(reader.get_bytes(2 * 8 + 2 * 4 + 3 * 8));  // up to `n`
  const std::size_t count = reader.get_count(8);
  if (reader.status() != Status::ok) return Status::malformed;
  if (count > rt::SegmentList::kMost) return Status::full;
  std::fill_n(list.segment, count, rt::ListedSegment{});
  return detail::read_any(message, list, seq);
}

Status encode(const rt::SensorTruth& truth, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  std::uint8_t canonical[rt::canonical_size<rt::SensorTruth>()];
  rt::encode_canonical(truth, canonical);
  return encode(CustomView{kChannelSensorTruth, truth.stamp_ns, seq, kSensorTruthFields, canonical}, out,
                size);
}

Status decode(std::span<const std::uint8_t> message, rt::SensorTruth& truth) noexcept {
  CustomView view;
  if (const Status status = decode(message, view); status != Status::ok) return status;
  if (view.fields != kSensorTruthFields || view.data.size() != rt::canonical_size<rt::SensorTruth>())
    return Status::malformed;
  rt::decode_canonical(view.data.data(), truth);
  return Status::ok;
}

}  // namespace sortie::drivers
