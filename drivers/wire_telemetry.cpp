// SPDX-License-Identifier: BSD-3-Clause
// Codecs of the telemetry messages; member order as in drivers/messages/*.lcm.
#include "drivers/wire_telemetry.hpp"

#include "drivers/wire_columns.hpp"

namespace sortie::drivers {

Status encode(std::int64_t utime, std::span<const TaskTiming> tasks, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintExecStats);
  writer.put(utime);
  writer.put_count(tasks.size());
  put_column(writer, tasks, &TaskTiming::task);
  put_column(writer, tasks, &TaskTiming::count);
  put_column(writer, tasks, &TaskTiming::missed);
  put_column(writer, tasks, &TaskTiming::p50_us);
  put_column(writer, tasks, &TaskTiming::p99_us);
  put_column(writer, tasks, &TaskTiming::max_us);
  put_column(writer, tasks, &TaskTiming::budget_us);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, std::int64_t& utime, std::vector<TaskTiming>& tasks) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintExecStats); type != Status::ok) return type;
  utime = reader.get<std::int64_t>();
  tasks.resize(reader.get_count(WireReader::kMinStringBytes + std::size_t{6} * 8));
  get_column(reader, tasks, &TaskTiming::task);
  get_column(reader, tasks, &TaskTiming::count);
  get_column(reader, tasks, &TaskTiming::missed);
  get_column(reader, tasks, &TaskTiming::p50_us);
  get_column(reader, tasks, &TaskTiming::p99_us);
  get_column(reader, tasks, &TaskTiming::max_us);
  get_column(reader, tasks, &TaskTiming::budget_us);
  return reader.finish();
}

Status encode(std::int64_t utime, std::span<const PoolUse> pools, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintPoolStats);
  writer.put(utime);
  writer.put_count(pools.size());
  put_column(writer, pools, &PoolUse::pool);
  put_column(writer, pools, &PoolUse::capacity);
  put_column(writer, pools, &PoolUse::used);
  put_column(writer, pools, &PoolUse::high_water);
  put_column(writer, pools, &PoolUse::refused);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, std::int64_t& utime, std::vector<PoolUse>& pools) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintPoolStats); type != Status::ok) return type;
  utime = reader.get<std::int64_t>();
  pools.resize(reader.get_count(WireReader::kMinStringBytes + std::size_t{4} * 8));
  get_column(reader, pools, &PoolUse::pool);
  get_column(reader, pools, &PoolUse::capacity);
  get_column(reader, pools, &PoolUse::used);
  get_column(reader, pools, &PoolUse::high_water);
  get_column(reader, pools, &PoolUse::refused);
  return reader.finish();
}

Status decode(std::span<const std::uint8_t> message, FieldsMessage& fields) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintFields); type != Status::ok) return type;
  fields.utime = reader.get<std::int64_t>();
  fields.task = reader.get_string();
  fields.values.resize(reader.get_count(WireReader::kMinStringBytes + 8));
  get_column(reader, fields.values, &NamedValue::name);
  get_column(reader, fields.values, &NamedValue::value);
  return reader.finish();
}

}  // namespace sortie::drivers
