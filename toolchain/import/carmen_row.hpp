// SPDX-License-Identifier: BSD-3-Clause
// One row of a CARMEN log: its name, its numbers, then stamp, host and the logger's time.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rt/samples.hpp"
#include "toolchain/import/importer.hpp"

namespace sortie::toolchain {

/// What a line of a CARMEN log turned out to be.
enum class CarmenLine : std::uint8_t {
  nothing,   ///< blank, a comment, or a setting
  odometry,  ///< ODOM
  laser,     ///< FLASER or ROBOTLASER1
  other,     ///< a row of another kind
  bad,       ///< damaged: see the fault
};

/// A row that was read.
struct CarmenRow {
  rt::Nanoseconds stamp_ns{};          ///< 0 to 9e9 s
  double x_m{}, y_m{}, heading_rad{};  ///< of the robot, by its odometry
  std::vector<rt::ScanPoint> points;   ///< laser: in its frame, x ahead, y left, z = 0
  ReturnCounts returns;
};

/// Reads line after line and remembers the settings (PARAM) on the way.
class CarmenReader {
 public:
  /// Without a setting in the log a reading of a FLASER row from here on is no return, as in CARMEN's own
  /// settings.
  static constexpr double kUsualRange_m = 50.0;

  /// `max_range_m` above 0 stands above what the log says.
  explicit CarmenReader(double max_range_m) : asked_range_m_(max_range_m) {}

  /// Reads a line. `row` is filled where it is odometry or laser; `fault` says what is wrong where it is bad.
  CarmenLine read(std::string_view line, CarmenRow& row, std::string& fault);

  /// The name of the row read last.
  std::string_view name() const { return fields_.empty() ? std::string_view() : fields_.front(); }
  /// How far ahead of the robot's origin the laser sits, as the log says; 0 without a word.
  double laser_offset_m() const { return offset_m_; }

 private:
  /// Readings of a laser: where they stand in the row and how they lie.
  struct Readings {
    std::size_t first{};
    std::size_t count{};
    double start_rad{};
    double step_rad{};
    double max_range_m{};
  };

  CarmenLine read_setting(std::string& fault);
  bool read_odometry(CarmenRow& row, std::string& fault);
  bool read_front_laser(CarmenRow& row, std::string& fault);
  bool read_robot_laser(CarmenRow& row, std::string& fault);
  bool count_at(std::size_t field, std::size_t& count, std::string& fault) const;
  bool has_fields(std::size_t count, std::string& fault) const;
  bool numbers(std::size_t first, std::size_t count, std::string& fault);
  bool pose_at(std::size_t field, CarmenRow& row, std::string& fault);
  bool stamp(CarmenRow& row, std::string& fault) const;
  bool place_readings(const Readings& readings, CarmenRow& row, std::string& fault) const;

  double asked_range_m_;
  double range_m_{kUsualRange_m};
  double offset_m_{};
  std::vector<std::string_view> fields_;
  std::vector<double> numbers_;
};

}  // namespace sortie::toolchain
