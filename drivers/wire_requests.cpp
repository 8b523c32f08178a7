// SPDX-License-Identifier: BSD-3-Clause
// Codec of requests to the drive; member order as in drivers/messages/drive_request_t.lcm.
#include "drivers/wire_requests.hpp"

#include "drivers/channels.hpp"
#include "drivers/wire_tag.hpp"

namespace sortie::drivers {

Status encode(const DriveRequestMessage& request, const SipKey* key, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintDriveRequest);
  writer.put(request.utime);
  writer.put(request.session);
  writer.put(request.sender);
  writer.put(request.counter);
  writer.put(request.speed_m_s);
  writer.put(request.turn_rad_s);
  writer.put(request.mode);
  writer.put(request.posture);
  writer.put(request.flags);
  put_tag(writer, key, out);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, const SipKey* key,
              DriveRequestMessage& request) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintDriveRequest); type != Status::ok)
    return type;
  DriveRequestMessage read;
  read.utime = reader.get<std::int64_t>();
  read.session = reader.get<std::int64_t>();
  read.sender = reader.get<std::int64_t>();
  read.counter = reader.get<std::int64_t>();
  read.speed_m_s = reader.get<double>();
  read.turn_rad_s = reader.get<double>();
  read.mode = reader.get<std::int32_t>();
  read.posture = reader.get<std::int32_t>();
  read.flags = reader.get<std::int32_t>();
  const Status end = finish_with_tag(reader, key, message);
  if (end == Status::ok) request = read;
  return end;
}

}  // namespace sortie::drivers
