// SPDX-License-Identifier: BSD-3-Clause
// Readers for the recorded data that the estimators' tests replay. Small and strict; for tests only.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace sortie::tests {

inline std::string data_path(const std::string& name) { return std::string(SORTIE_DATA_DIR) + "/" + name; }

inline bool has_data(const std::string& name) { return std::ifstream(data_path(name)).good(); }

/// Rows of numbers, separated by commas or blanks; lines that do not begin like a number are left out.
inline std::vector<std::vector<double>> read_numbers(const std::string& name) {
  std::ifstream file(data_path(name));
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0; words >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

/// Seconds as decimal text would give them, to the nearest nanosecond after `epoch_s`.
inline std::int64_t to_ns(double seconds, double epoch_s) {
  return static_cast<std::int64_t>(std::llround((seconds - epoch_s) * 1e9));
}

/// One record of a .imu file: gyr 3, acc 3, mag 3, reference quaternion 4, reference position 3, moving.
struct ImuRecord {
  float value[17];
};

/// Empty where the file cannot be read.
inline std::vector<ImuRecord> read_imu_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char magic[4]{};
  std::uint32_t count = 0;
  double rate_hz = 0;
  file.read(magic, 4);
  file.read(reinterpret_cast<char*>(&count), 4);
  file.read(reinterpret_cast<char*>(&rate_hz), 8);
  std::vector<ImuRecord> records;
  if (!file || std::memcmp(magic, "IMU1", 4) != 0) return records;
  records.resize(count);
  file.read(reinterpret_cast<char*>(records.data()), static_cast<std::streamsize>(count * sizeof(ImuRecord)));
  if (!file) records.clear();
  return records;
}

inline std::vector<ImuRecord> read_imu(const std::string& name) { return read_imu_file(data_path(name)); }

}  // namespace sortie::tests
