// SPDX-License-Identifier: BSD-3-Clause
// Codec of requests to the pilot; member order as in drivers/messages/fly_request_t.lcm.
#include "drivers/wire_fly.hpp"

#include "drivers/channels.hpp"
#include "drivers/wire_tag.hpp"

namespace sortie::drivers {

Status encode(const FlyRequestMessage& request, const SipKey* key, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintFlyRequest);
  for (const std::int64_t number : {request.utime, request.session, request.sender, request.counter})
    writer.put(number);
  for (const double number : {request.x_m, request.y_m, request.z_m, request.yaw_rad}) writer.put(number);
  writer.put(request.mode);
  put_tag(writer, key, out);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, const SipKey* key, FlyRequestMessage& request) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintFlyRequest); type != Status::ok) return type;
  FlyRequestMessage read;
  for (std::int64_t* number : {&read.utime, &read.session, &read.sender, &read.counter})
    *number = reader.get<std::int64_t>();
  for (double* number : {&read.x_m, &read.y_m, &read.z_m, &read.yaw_rad}) *number = reader.get<double>();
  read.mode = reader.get<std::int32_t>();
  const Status end = finish_with_tag(reader, key, message);
  if (end == Status::ok) request = read;
  return end;
}

}  // namespace sortie::drivers
