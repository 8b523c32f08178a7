// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: any bytes are walked as an event log, and the messages of its events are decoded.
// Both ways of meeting damage must end, stay inside the bytes, and agree on all events before the first
// damage. What a codec takes must come out of it again byte for byte.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "drivers/ssl_port.hpp"
#include "drivers/wire.hpp"
#include "drivers/wire_cursor.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_ssl.hpp"
#include "drivers/wire_telemetry.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

using Message = std::span<const std::uint8_t>;

void require(bool condition) {
  if (!condition) std::abort();
}

template <class Encode>
void require_same(Message message, Encode&& encode) {
  std::vector<std::uint8_t> again(message.size());
  std::size_t size = 0;
  require(encode(std::span<std::uint8_t>(again), size) == Status::ok);
  require(size == message.size() && std::equal(again.begin(), again.end(), message.begin()));
}

void decode_samples(Message message) {
  std::int64_t seq = 0;
  rt::ImuSample imu;
  rt::TrackSample track;
  rt::TruthSample truth;
  CanFrame frame;
  if (decode(message, imu, seq) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(imu, seq, out, size); });
  }
  if (decode(message, track, seq) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(track, seq, out, size); });
  }
  if (decode(message, truth) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(truth, out, size); });
  }
  if (decode(message, frame) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(frame, out, size); });
  }
  static rt::ScanPoint points[64];
  rt::PointScan scan;
  if (decode(message, scan.header, points, seq) == Status::ok) {
    scan.points = points;
    require_same(message, [&](auto out, auto& size) { return encode(scan, seq, out, size); });
  }
}

void decode_ssl(Message message) {
  rt::SslCommand command;
  rt::SslReturns returns;
  std::int64_t seq = 0;
  if (decode(message, command, seq) == Status::ok) {
    require(can_be_fired(command));
    require_same(message, [&](auto out, auto& size) { return encode(command, seq, out, size); });
  }
  if (decode(message, returns, seq) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(returns, seq, out, size); });
  }
}

void decode_records(Message message) {
  LogHeader header;
  rt::JobRecord tick;
  GapRecord gap;
  CustomView custom;
  PoseMessage pose;
  // A boolean of a stranger may be any byte; it comes back as 0 or 1.
  if (decode(message, header) == Status::ok) require(encoded_bytes(header) == message.size());
  if (decode(message, tick) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(tick, out, size); });
  }
  if (decode(message, gap) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(gap, out, size); });
  }
  if (decode(message, custom) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(custom, out, size); });
  }
  if (decode(message, pose) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(pose, out, size); });
  }
}

void decode_telemetry(Message message) {
  ExecStats tasks;
  PoolStats pools;
  FieldsMessage fields;
  JobTimingRecord timing;
  if (decode(message, tasks) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(tasks, out, size); });
  }
  if (decode(message, pools) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(pools, out, size); });
  }
  if (decode(message, fields) == Status::ok) {
    require_same(message, [&](auto out, auto& size) { return encode(fields, out, size); });
  }
  if (decode(message, timing) == Status::ok) require(timing.duration_ns.size() <= message.size() / 8);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Message bytes(data, size);
  LcmLogCursor cursor(bytes);
  LogEvent event;
  Status status = Status::ok;
  while ((status = cursor.next(event)) == Status::ok) {
    require(event.data.empty() ||
            (event.data.data() >= data && event.data.data() + event.data.size() <= data + size));
    decode_samples(event.data);
    decode_ssl(event.data);
    decode_records(event.data);
    decode_telemetry(event.data);
  }
  if (status == Status::empty) {
    require(cursor.position() == size);
  } else {
    require(cursor.position() < size && !cursor.problem().describe().empty());
    require(cursor.next(event) == Status::malformed);
  }
  // No fuzzer guesses a fingerprint: the first byte chooses one, the rest is the message behind it.
  if (size == 0) return 0;
  const std::uint64_t fingerprint = kMessageTypes[data[0] % kMessageTypes.size()].fingerprint;
  std::vector<std::uint8_t> message(8);
  WireWriter(message).put(fingerprint);
  message.insert(message.end(), data + 1, data + size);
  decode_samples(message);
  decode_ssl(message);
  decode_records(message);
  decode_telemetry(message);
  return 0;
}
