// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire_timing.hpp"

#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

Status encode(const JobTiming& timing, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintTiming);
  writer.put(timing.tick);
  writer.put(timing.group);
  writer.put(timing.started_ns);
  writer.put_count(timing.duration_ns.size());
  for (const std::uint32_t duration : timing.duration_ns) writer.put(static_cast<std::int64_t>(duration));
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, JobTimingRecord& timing) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintTiming); type != Status::ok) return type;
  timing.tick = reader.get<std::int64_t>();
  timing.group = reader.get<std::int32_t>();
  timing.started_ns = reader.get<std::int64_t>();
  timing.duration_ns.resize(reader.get_count(8));
  for (std::int64_t& duration : timing.duration_ns) duration = reader.get<std::int64_t>();
  return reader.finish();
}

Status encode_fields(std::int64_t utime, std::string_view task, std::span<const NamedValue> values,
                     std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintFields);
  writer.put(utime);
  writer.put_string(task);
  writer.put_count(values.size());
  for (const NamedValue& entry : values) writer.put_string(entry.name);
  for (const NamedValue& entry : values) writer.put(entry.value);
  return writer.finish(size);
}

}  // namespace sortie::drivers
