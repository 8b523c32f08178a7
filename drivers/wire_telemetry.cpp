// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire_telemetry.hpp"

namespace sortie::drivers {
namespace {

// The rows keep their memory.
template <class Row>
Status decode_rows(std::span<const std::uint8_t> message, std::int64_t& utime, std::vector<Row>& rows) {
  StatsMessage<std::vector<Row>> read{utime, std::move(rows)};
  std::int64_t none = 0;
  const Status status = detail::read_any(message, read, none);
  utime = read.utime;
  rows = std::move(read.rows);
  return status;
}

}  // namespace

Status encode(std::int64_t utime, std::span<const TaskTiming> tasks, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  return encode(StatsMessage<std::span<const TaskTiming>>{utime, tasks}, out, size);
}
Status encode(std::int64_t utime, std::span<const PoolUse> pools, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  return encode(StatsMessage<std::span<const PoolUse>>{utime, pools}, out, size);
}

Status decode(std::span<const std::uint8_t> message, std::int64_t& utime, std::vector<TaskTiming>& tasks) {
  return decode_rows(message, utime, tasks);
}
Status decode(std::span<const std::uint8_t> message, std::int64_t& utime, std::vector<PoolUse>& pools) {
  return decode_rows(message, utime, pools);
}

}  // namespace sortie::drivers
