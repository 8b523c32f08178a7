// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire_sensor_truth.hpp"

#include "drivers/wire_records.hpp"
#include "rt/fields.hpp"

namespace sortie::drivers {

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
