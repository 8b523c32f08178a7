// SPDX-License-Identifier: BSD-3-Clause
// Rows as CARMEN's logger writes them:
//   ODOM x y theta tv rv accel | FLASER n r... x y theta odom_x odom_y odom_theta
//   ROBOTLASER1 type start fov step range accuracy remissions n r... m s... laser_x laser_y laser_theta
//     robot_x robot_y robot_theta tv rv forward side turn
// each followed by stamp, host and logger's time.
#include "toolchain/import/carmen_row.hpp"

#include <charconv>
#include <cmath>

#include "rt/math.hpp"
#include "toolchain/import/text_file.hpp"

namespace sortie::toolchain {
namespace {

constexpr double kPi_rad = 3.14159265358979323846;
constexpr double kFarthest = 1e7;        // m and rad: nothing that was driven is farther
constexpr std::size_t kStampFields = 3;  // stamp, host and logger's time end each row

bool is_name(std::string_view text) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  return !text.empty() && text.size() <= 24 && text.front() >= 'A' && text.front() <= 'Z' &&
         text.find_first_not_of(kLetters) == std::string_view::npos;
}

}  // namespace

CarmenLine CarmenReader::read(std::string_view line, CarmenRow& row, std::string& fault) {
  split(line, ' ', fields_);
  if (fields_.empty() || fields_.front().front() == '#') return CarmenLine::nothing;
  row = {};
  if (name() == "PARAM") return read_setting(fault);
  if (name() == "ODOM") return read_odometry(row, fault) ? CarmenLine::odometry : CarmenLine::bad;
  if (name() == "FLASER") return read_front_laser(row, fault) ? CarmenLine::laser : CarmenLine::bad;
  if (name() == "ROBOTLASER1") return read_robot_laser(row, fault) ? CarmenLine::laser : CarmenLine::bad;
  if (is_name(name())) return CarmenLine::other;
  fault = quote(name()) + " is no name of a row";
  return CarmenLine::bad;
}

CarmenLine CarmenReader::read_setting(std::string& fault) {
  const bool range = fields_.size() > 1 && fields_[1] == "robot_front_laser_max";
  const bool offset = fields_.size() > 1 && fields_[1] == "robot_frontlaser_offset";
  if (!range && !offset) return CarmenLine::nothing;
  double value = 0.0;
  const bool fits = fields_.size() > 2 && parse_double(fields_[2], value) && std::fabs(value) <= kFarthest;
  if (!fits || (range && !(value > 0.0))) {
    fault = "setting " + std::string(fields_[1]) + " is no length in m";
    return CarmenLine::bad;
  }
  (range ? range_m_ : offset_m_) = value;
  return CarmenLine::nothing;
}

bool CarmenReader::read_odometry(CarmenRow& row, std::string& fault) {
  return has_fields(1 + 6, fault) && numbers(1, 6, fault) && pose_at(1, row, fault) && stamp(row, fault);
}

bool CarmenReader::read_front_laser(CarmenRow& row, std::string& fault) {
  Readings r;
  r.first = 2;
  if (!count_at(1, r.count, fault) || !has_fields(2 + r.count + 6, fault)) return false;
  // 181 readings are a degree apart and so are 180, of which the last is left out.
  r.start_rad = -0.5 * kPi_rad;
  r.step_rad = kPi_rad / static_cast<double>(r.count % 2 == 1 && r.count > 1 ? r.count - 1 : r.count);
  r.max_range_m = asked_range_m_ > 0.0 ? asked_range_m_ : range_m_;
  const std::size_t pose = 2 + r.count;
  return numbers(pose, 6, fault) && pose_at(pose + 3, row, fault) && stamp(row, fault) &&
         place_readings(r, row, fault);
}

bool CarmenReader::read_robot_laser(CarmenRow& row, std::string& fault) {
  Readings r;
  r.first = 9;
  std::size_t remissions = 0;
  if (!count_at(8, r.count, fault)) return false;
  const std::size_t after = 9 + r.count;
  if (fields_.size() <= after) return has_fields(after + 1 + 11, fault);
  if (!count_at(after, remissions, fault)) return false;
  const std::size_t pose = after + 1 + remissions;
  if (!has_fields(pose + 11, fault) || !numbers(1, 7, fault)) return false;
  r.start_rad = numbers_[1];
  r.step_rad = numbers_[3];
  r.max_range_m = asked_range_m_ > 0.0 ? std::fmin(asked_range_m_, numbers_[4]) : numbers_[4];
  const double span_rad = r.step_rad * static_cast<double>(r.count > 0 ? r.count - 1 : 0);
  if (std::fabs(r.start_rad) > 2.0 * kPi_rad || !(r.step_rad > 0.0) || span_rad > 2.0 * kPi_rad) {
    fault = "its readings do not lie within one turn (start " + std::string(fields_[2]) + ", step " +
            std::string(fields_[4]) + ")";
    return false;
  }
  if (!(r.max_range_m > 0.0)) return fault = "its range is not above 0", false;
  return numbers(after + 1, remissions, fault) && numbers(pose, 11, fault) && pose_at(pose + 3, row, fault) &&
         stamp(row, fault) && place_readings(r, row, fault);
}

bool CarmenReader::count_at(std::size_t field, std::size_t& count, std::string& fault) const {
  if (fields_.size() <= field) return fault = "it ends before the number of its readings", false;
  const std::string_view text = fields_[field];
  const auto result = std::from_chars(text.data(), text.data() + text.size(), count);
  const bool number = result.ec == std::errc{} && result.ptr == text.data() + text.size();
  if (number && count <= fields_.size()) return true;
  fault = quote(text) + (number ? " readings do not fit into " + std::to_string(fields_.size()) + " columns"
                                : std::string(" is no number of readings"));
  return false;
}

bool CarmenReader::has_fields(std::size_t count, std::string& fault) const {
  if (fields_.size() == count + kStampFields) return true;
  fault = std::to_string(fields_.size()) + " columns instead of " + std::to_string(count + kStampFields);
  return false;
}

bool CarmenReader::numbers(std::size_t first, std::size_t count, std::string& fault) {
  numbers_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view field = fields_[first + i];
    const std::string shown = "column " + std::to_string(first + i + 1) + " is " + quote(field);
    if (!parse_double(field, numbers_[i])) return fault = shown + ", no number", false;
    if (!std::isfinite(numbers_[i])) return fault = shown + ", not finite", false;
  }
  return true;
}

bool CarmenReader::pose_at(std::size_t field, CarmenRow& row, std::string& fault) {
  if (!numbers(field, 3, fault)) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::fabs(numbers_[i]) <= kFarthest) continue;
    fault = "column " + std::to_string(field + i + 1) + " is " + quote(fields_[field + i]) + ", beyond 1e7";
    return false;
  }
  row.x_m = numbers_[0];
  row.y_m = numbers_[1];
  row.heading_rad = numbers_[2];
  return true;
}

bool CarmenReader::stamp(CarmenRow& row, std::string& fault) const {
  const std::string_view field = fields_[fields_.size() - kStampFields];
  double logged_s = 0.0;
  if (!parse_seconds(field, row.stamp_ns)) return fault = "its stamp is " + quote(field) + ", no time", false;
  if (row.stamp_ns < 0 || row.stamp_ns > kLatestStamp_ns)
    return fault = "its stamp is " + quote(field) + ", not within 0 to 9e9 s", false;
  if (!parse_double(fields_.back(), logged_s))
    return fault = "the logger's time is " + quote(fields_.back()) + ", no time", false;
  return true;
}

bool CarmenReader::place_readings(const Readings& readings, CarmenRow& row, std::string& fault) const {
  if (readings.count == 0) return fault = "it has no reading", false;
  row.points.reserve(readings.count);
  row.returns.in = readings.count;
  for (std::size_t i = 0; i < readings.count; ++i) {
    const std::string_view field = fields_[readings.first + i];
    double range_m = 0.0;
    if (!parse_double(field, range_m))
      return fault = "reading " + std::to_string(i) + " is " + quote(field) + ", no number", false;
    if (!std::isfinite(range_m)) {
      ++row.returns.not_finite;
    } else if (!(range_m > 0.0 && range_m < readings.max_range_m)) {
      ++row.returns.out_of_range;
    } else {
      const rt::SinCos angle = rt::sincos(readings.start_rad + static_cast<double>(i) * readings.step_rad);
      rt::ScanPoint point;
      point.x_m = static_cast<float>(range_m * angle.cos);
      point.y_m = static_cast<float>(range_m * angle.sin);
      row.points.push_back(point);
      ++row.returns.used;
    }
  }
  return true;
}

}  // namespace sortie::toolchain
