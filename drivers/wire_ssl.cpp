// SPDX-License-Identifier: BSD-3-Clause
// Codecs of the solid-state lidar; member order as in drivers/messages/ssl_*.lcm.
#include "drivers/wire_ssl.hpp"

#include <algorithm>

#include "drivers/channels.hpp"
#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {
namespace {

template <class Sample>
void put_head(WireWriter& writer, std::uint64_t fingerprint, const Sample& sample, std::int64_t seq) {
  writer.put(fingerprint);
  writer.put(sample.stamp_ns);
  writer.put(seq);
  writer.put(sample.number);
  writer.put_count(sample.rays);
  writer.put_array(sample.direction, sample.rays);
}

// What is not, is refused when it is read, so it is not written either.
template <class Sample>
bool is_one(const Sample& sample) {
  return sample.rays <= rt::kSslMaxRays &&
         std::all_of(sample.direction, sample.direction + sample.rays,
                     [](std::uint16_t direction) { return direction < rt::kSslDirections; });
}

template <class Sample>
Status get_head(WireReader& reader, std::uint64_t fingerprint, Sample& sample, std::int64_t& seq) {
  if (const Status type = expect_fingerprint(reader, fingerprint); type != Status::ok) return type;
  sample.stamp_ns = reader.get<std::int64_t>();
  seq = reader.get<std::int64_t>();
  sample.number = reader.get<std::uint32_t>();
  const std::size_t rays = reader.get_count(sizeof(std::uint16_t));
  if (reader.status() != Status::ok || rays > rt::kSslMaxRays) return Status::malformed;
  sample.rays = static_cast<std::uint32_t>(rays);
  reader.get_array(sample.direction, rays);
  return is_one(sample) ? reader.status() : Status::malformed;
}

}  // namespace

Status encode(const rt::SslCommand& command, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  size = 0;
  if (!is_one(command)) return Status::out_of_range;
  WireWriter writer(out);
  put_head(writer, kFingerprintSslCommand, command, seq);
  return writer.finish(size);
}

Status encode(const rt::SslReturns& returns, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  size = 0;
  if (!is_one(returns)) return Status::out_of_range;
  WireWriter writer(out);
  put_head(writer, kFingerprintSslReturns, returns, seq);
  writer.put_array(returns.range_mm, returns.rays);
  writer.put_array(returns.age_10us, returns.rays);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::SslCommand& command, std::int64_t& seq) noexcept {
  WireReader reader(message);
  rt::SslCommand read;
  std::int64_t number = 0;
  if (const Status head = get_head(reader, kFingerprintSslCommand, read, number); head != Status::ok)
    return head;
  if (reader.finish() != Status::ok) return Status::malformed;
  command = read;
  seq = number;
  return Status::ok;
}

Status decode(std::span<const std::uint8_t> message, rt::SslReturns& returns, std::int64_t& seq) noexcept {
  WireReader reader(message);
  rt::SslReturns read;
  std::int64_t number = 0;
  if (const Status head = get_head(reader, kFingerprintSslReturns, read, number); head != Status::ok)
    return head;
  reader.get_array(read.range_mm, read.rays);
  reader.get_array(read.age_10us, read.rays);
  if (reader.finish() != Status::ok) return Status::malformed;
  returns = read;
  seq = number;
  return Status::ok;
}

}  // namespace sortie::drivers
