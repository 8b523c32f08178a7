// SPDX-License-Identifier: BSD-3-Clause
// A recording as a bare board reads it: records of one size, little endian, in the order of arrival. Written
// by tests/tools/bare_recording from a log or a simulation.
#pragma once

#include <cstdint>

#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::bare {

/// What a record holds.
enum class RecordKind : std::uint32_t {
  imu = 1,    ///< value: turn rate x y z, specific force x y z
  track = 2,  ///< value: left, right
  fix = 3,    ///< value: position x y z, yaw
  goal = 4,   ///< value: position x y z, yaw
};

/// One record, 80 bytes.
struct Record {
  std::int64_t arrival_ns{};
  std::int64_t stamp_ns{};
  RecordKind kind{};
  std::uint32_t flags{};
  double value[7]{};
};
static_assert(sizeof(Record) == 80);

inline rt::ImuSample to_imu(const Record& record) {
  rt::ImuSample sample;
  sample.stamp_ns = record.stamp_ns;
  for (int i = 0; i < 3; ++i) {
    sample.gyr_rad_s[i] = record.value[i];
    sample.acc_m_s2[i] = record.value[3 + i];
  }
  sample.flags = record.flags;
  return sample;
}

inline rt::TrackSample to_track(const Record& record) {
  return {record.stamp_ns, record.value[0], record.value[1], record.flags};
}

inline rt::UavFix to_fix(const Record& record) {
  return {
      record.stamp_ns, {record.value[0], record.value[1], record.value[2]}, record.value[3], record.flags};
}

}  // namespace sortie::bare
