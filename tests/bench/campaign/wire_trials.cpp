// SPDX-License-Identifier: BSD-3-Clause
// What comes from outside, under the campaign: messages with damaged bytes, frames of the bus.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <memory>

#include "drivers/can_codec.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_requests.hpp"
#include "drivers/wire_ssl.hpp"
#include "tests/bench/campaign/trial.hpp"
#include "tests/bench/campaign/trials.hpp"

namespace sortie::bench {

namespace {

constexpr std::size_t kMessageBytes = 512;

// A message of some kind, whole; `size` 0 where the values could not be sent.
std::size_t message_of(const CampaignOp& op, std::span<std::uint8_t> out) {
  const auto& v = op.value;
  std::size_t size = 0;
  switch (op.kind % 5) {
    case 0: {
      const rt::ImuSample sample{op.step_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}, 3};
      return drivers::encode(sample, 7, out, size) == Status::ok ? size : 0;
    }
    case 1: {
      const rt::TrackSample sample{op.step_ns, v[0], v[1], 0};
      return drivers::encode(sample, 8, out, size) == Status::ok ? size : 0;
    }
    case 2: {
      rt::ScanPoint points[3]{};
      points[0].x_m = static_cast<float>(v[0]);
      rt::PointScan scan;
      scan.header.stamp_ns = op.step_ns;
      scan.header.points = whole_of(v[1], 4);
      scan.points = points;
      return drivers::encode(scan, 9, out, size) == Status::ok ? size : 0;
    }
    case 3: {
      drivers::DriveRequestMessage request;
      request.utime = op.step_ns;
      request.speed_m_s = v[0];
      request.turn_rad_s = v[1];
      return drivers::encode(request, nullptr, out, size) == Status::ok ? size : 0;
    }
    default: {
      drivers::CanFrame frame;
      frame.stamp_ns = op.step_ns;
      frame.id = whole_of(v[0], 2048);
      frame.size = static_cast<std::uint8_t>(whole_of(v[1], 9));
      std::memcpy(frame.data, &v[2], 8);
      return drivers::encode(frame, out, size) == Status::ok ? size : 0;
    }
  }
}

// Damage: a byte, the length, or the head of another message.
std::size_t damage(const CampaignOp& op, std::span<std::uint8_t> bytes, std::size_t size) {
  if (op.kind / 5 % 4 == 1 && size > 0)
    bytes[whole_of(op.value[5], static_cast<std::uint32_t>(size))] ^= 0x41;
  if (op.kind / 5 % 4 == 2) return whole_of(op.value[5], kMessageBytes);
  if (op.kind / 5 % 4 == 3) std::memcpy(bytes.data(), op.value, std::min<std::size_t>(size, sizeof op.value));
  return size;
}

// Every decoder gets every message: at most one takes it, and takes it again as it would send it.
std::uint32_t decode_all(CampaignTrial& trial, std::span<const std::uint8_t> message) {
  std::uint32_t takers = 0;
  std::uint8_t again[kMessageBytes];
  std::size_t size = 0;
  std::int64_t seq = 0;
  const auto same = [&](Status encoded) {
    trial.need(
        encoded == Status::ok && size == message.size() && std::equal(again, again + size, message.begin()),
        "what was taken is sent as other bytes");
    ++takers;
  };
  rt::ImuSample imu;
  if (drivers::decode(message, imu, seq) == Status::ok) same(drivers::encode(imu, seq, again, size));
  rt::TrackSample track;
  if (drivers::decode(message, track, seq) == Status::ok) same(drivers::encode(track, seq, again, size));
  rt::ScanPoint points[8];
  rt::PointScan scan;
  const Status scanned = drivers::decode(message, scan.header, points, seq);
  scan.points = points;
  if (scanned == Status::ok) {
    trial.need(scan.header.points <= std::size(points), "more points came than there is room for");
    same(drivers::encode(scan, seq, again, size));
  }
  drivers::DriveRequestMessage request;
  if (drivers::decode(message, nullptr, request) == Status::ok) {
    ++takers;
    trial.fold(static_cast<std::uint64_t>(static_cast<std::int32_t>(request.mode)));  // as it travels
  }
  drivers::CanFrame frame;
  if (drivers::decode(message, frame) == Status::ok) {
    trial.need(frame.size <= 8, "a frame has more than eight bytes");
    ++takers;
  }
  rt::SslReturns returns;
  if (drivers::decode(message, returns, seq) == Status::ok) ++takers;
  drivers::PoseMessage pose;
  if (drivers::decode(message, pose) == Status::ok) ++takers;
  drivers::Lc02Message datagram;
  if (drivers::parse_lc02(message, datagram) == Status::ok)
    trial.need(datagram.payload.size() < message.size(), "a payload is longer than its datagram");
  return takers;
}

}  // namespace

CampaignOutcome run_wire_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  for (const CampaignOp& op : ops) {
    std::uint8_t bytes[kMessageBytes]{};
    const std::size_t whole = message_of(op, bytes);
    const std::size_t size = damage(op, bytes, whole);
    const std::uint32_t takers = trial.real_time([&] { return decode_all(trial, {bytes, size}); });
    trial.count(takers > 0);
    trial.need(takers <= 1, "two kinds of message took the same bytes");
    trial.need(takers == 1 || whole == 0 || op.kind / 5 % 4 != 0, "a whole message was refused");
  }
  return trial.end();
}

CampaignOutcome run_can_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  const auto decoder = std::make_unique<drivers::CanSampleDecoder>();
  CampaignClock clock;
  rt::Nanoseconds last_imu = INT64_MIN;
  rt::Nanoseconds last_track = INT64_MIN;
  std::uint64_t frames = 0;
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    const rt::Nanoseconds stamp = clock.step(op);
    drivers::CanFrame out[4];
    std::size_t made = 0;
    // The devices' counters come from stamps that may be as wild as the bus', and encoders may be refused a
    // value.
    const std::uint16_t counter =
        drivers::can_time_counter(stamp > -(1LL << 61) && stamp < (1LL << 61) ? stamp : 0);
    if (op.kind % 4 == 0) {
      const rt::ImuSample sample{stamp, {v[0], v[1], v[2]}, {v[3], v[4], 9.81 + v[5]}, 3};
      made = trial.answered(drivers::encode_imu(sample, counter, out)) == Status::ok ? 2 : 0;
    } else if (op.kind % 4 == 1) {
      const rt::TrackSample sample{stamp, 10.0 * v[0], 10.0 * v[1], 0};
      made = trial.answered(drivers::encode_track(sample, counter, out)) == Status::ok ? 2 : 0;
    } else {
      made = 1;
      out[0].id = op.kind % 4 == 2
                      ? drivers::kCanFrames[whole_of(v[0], 64) % std::size(drivers::kCanFrames)].id
                      : whole_of(v[0], 2048);
      const drivers::CanMessage* spec = drivers::find_can_frame(out[0].id);
      out[0].size =
          static_cast<std::uint8_t>(spec != nullptr && v[1] > -0.5 ? spec->size : whole_of(v[1], 16));
      out[0].flags = static_cast<std::uint8_t>(v[2] > 0.9 ? whole_of(v[2], 256) : 0);
      std::memcpy(out[0].data, &v[3], 8);
    }
    if (made == 2 && v[6] > 0.9) made = 1;  // the partner is lost
    for (std::size_t i = 0; i < made; ++i) {
      out[i].stamp_ns = stamp;
      ++frames;
      drivers::CanSample sample;
      const Status status = trial.answered(trial.real_time([&] { return decoder->decode(out[i], sample); }));
      trial.need(status == Status::ok || sample.kind == drivers::CanSampleKind::none,
                 "a refused frame gave a sample");
      if (sample.kind == drivers::CanSampleKind::imu) {
        trial.see(sample.imu, "an inertial sample is not finite");
        trial.need(sample.imu.stamp_ns > last_imu, "inertial samples are not in order");
        last_imu = sample.imu.stamp_ns;
      } else if (sample.kind == drivers::CanSampleKind::track) {
        trial.see(sample.track, "a sample of the tracks is not finite");
        trial.need(sample.track.stamp_ns > last_track, "samples of the tracks are not in order");
        last_track = sample.track.stamp_ns;
      } else if (sample.kind == drivers::CanSampleKind::flipper) {
        trial.see(sample.flipper, "a sample of the flippers is not finite");
      } else if (sample.kind == drivers::CanSampleKind::fix) {
        trial.see(sample.fix, "a fix is not finite");
      }
    }
  }
  const drivers::CanDecodeCounters& c = decoder->counters();
  const std::uint64_t single = c.drive_frames + c.flipper_frames + c.rotor_frames + c.unknown_id +
                               c.remote_frames + c.error_frames + c.wrong_size + c.missing_partner +
                               c.out_of_time;
  const std::uint64_t pairs =
      c.imu_samples + c.track_samples + c.fix_samples + c.time_repeated + c.time_backwards + c.encoder_jumps;
  trial.need(c.frames == frames, "frames were offered that nobody counted");
  trial.need(c.frames == single + 2 * pairs + 4 * (c.flipper_samples + c.flipper_order) +
                             static_cast<std::uint64_t>(decoder->pending()),
             "frames and counters do not add up");
  return trial.end();
}

}  // namespace sortie::bench
