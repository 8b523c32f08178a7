// SPDX-License-Identifier: BSD-3-Clause
// BROAD (D. Laidig et al., 2021, CC BY 4.0): inertial readings at 285.7 Hz with orientation and position from
// optics. File: 'IMU1', u32 records, f64 rate in Hz, then records of 17 f32: gyr[3], acc[3], mag[3], q[4],
// p[3], moving.
#include <array>
#include <cmath>

#include "toolchain/import/binary_file.hpp"
#include "toolchain/import/data_set.hpp"
#include "toolchain/import/kinds.hpp"

namespace sortie::toolchain {
namespace {

constexpr std::size_t kFields = 17;
constexpr std::size_t kReference = 9;  ///< first field of the truth

using Record = std::array<float, kFields>;

bool all_finite(const Record& record, std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) {
    if (!std::isfinite(record[i])) return false;
  }
  return true;
}

rt::ImuSample imu_of(const Record& r, rt::Nanoseconds stamp_ns) {
  rt::ImuSample sample;
  sample.stamp_ns = stamp_ns;
  for (std::size_t i = 0; i < 3; ++i) {
    sample.gyr_rad_s[i] = static_cast<double>(r[i]);
    sample.acc_m_s2[i] = static_cast<double>(r[3 + i]);
  }
  // Measured on all four trials: turns over 0.2 s agree with the optics 15-35 % better if a reading is taken
  // as the mean since the one before than as a point in time (the sensor's own low-pass lags by about as
  // much).
  sample.flags = rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate;
  return sample;
}

/// The truth of a record; flags are 0 where the markers were hidden.
rt::TruthSample truth_of(const Record& r, rt::Nanoseconds stamp_ns) {
  rt::TruthSample sample;
  sample.stamp_ns = stamp_ns;
  if (all_finite(r, kReference, kReference + 4)) {
    for (std::size_t i = 0; i < 4; ++i) sample.q_world_body[i] = static_cast<double>(r[kReference + i]);
    sample.flags |= rt::kTruthOrientation;
  }
  if (all_finite(r, kReference + 4, kReference + 7)) {
    for (std::size_t i = 0; i < 3; ++i) sample.p_world_body_m[i] = static_cast<double>(r[kReference + 4 + i]);
    sample.flags |= rt::kTruthPosition | rt::kTruthHeight;
  }
  if (sample.flags != 0 && r[kFields - 1] > 0.5f) sample.flags |= rt::kTruthMoving;
  return sample;
}

}  // namespace

void import_broad(RowJudge& judge, LogBuilder& builder) {
  const std::string path = find_set(judge.options().path, ".imu", {}, "broad") + ".imu";
  BinaryFile file(path, "IMU1", "a BROAD trial (.imu)");
  judge.begin(path);
  std::uint32_t count = 0;
  double rate_hz = 0.0;
  if (!file.get(count) || !file.get(rate_hz) || !(rate_hz > 0.1 && rate_hz < 1e6)) {
    throw firmware::InputError(
        path + ": byte 4: the head is damaged (number of records, rate in Hz); copy the file again");
  }
  Record record{};
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint64_t offset = file.position();
    if (!file.get(record)) {
      judge.cut_off(offset, std::to_string(k) + " of " + std::to_string(count) + " records are whole");
      break;
    }
    const auto stamp_ns =
        static_cast<rt::Nanoseconds>(std::floor(static_cast<double>(k) / rate_hz * 1e9 + 0.5));
    const std::string place = path + ": record " + std::to_string(k) + " at byte " + std::to_string(offset);
    if (!all_finite(record, 0, kReference)) {
      judge.bad(place, "a reading is not finite");
    } else {
      judge.good();
      builder.add(stamp_ns, imu_of(record, stamp_ns));
    }
    const rt::TruthSample truth = truth_of(record, stamp_ns);
    if (truth.flags == 0) {
      judge.hidden_truth();
    } else {
      builder.add(stamp_ns, truth);
    }
  }
  if (file.left() > 0 && judge.rows() == count) {
    judge.warn(path + ": " + std::to_string(file.left()) + " bytes behind the last record were not used");
  }
  judge.finish(true);
}

}  // namespace sortie::toolchain
