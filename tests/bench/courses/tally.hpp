// SPDX-License-Identifier: BSD-3-Clause
// What a driver did over some courses, as a row of a table.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "hil/plant/course_judge.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// `value` to the nearest whole share of 1, of which `shares` make 1.
inline double rounded_to(double value, double shares) { return std::round(value * shares) / shares; }

/// What a driver did over some courses.
struct Tally {
  int reached{}, tipped{}, refused_early{}, refused_late{}, other{};
  Rounds rate_deg_s, vertical_m_s2, time_s, belly;

  /// Adds how a drive ended.
  void count(const hil::CourseResult& r) {
    if (r.end == hil::CourseEnd::reached)
      ++reached;
    else if (r.end == hil::CourseEnd::tipped)
      ++tipped;
    else if (r.refused_before_contact())
      ++refused_early;
    else if (r.end == hil::CourseEnd::refused)
      ++refused_late;
    else
      ++other;
  }
  /// Adds how it went: of drives that reached their goals.
  void weigh(const hil::CourseResult& r) {
    rate_deg_s.add(57.29577951308232 * r.peak_pitch_rate_rad_s);
    vertical_m_s2.add(r.peak_vertical_m_s2);
    time_s.add(r.time_s);
    belly.add(r.belly_contacts);
  }
  /// The row, behind its first cells.
  Json values(Json cells) const {
    for (const int n : {reached, tipped, refused_early, refused_late, other}) cells.push_back(n);
    if (rate_deg_s.empty()) {
      for (int k = 0; k < 4; ++k) cells.push_back("-");
      return cells;
    }
    double touches = 0.0;
    for (const double n : belly.values()) touches += n;
    cells.push_back(rounded_to(rate_deg_s.median(), 1));
    cells.push_back(rounded_to(vertical_m_s2.median(), 10));
    cells.push_back(rounded_to(touches / static_cast<double>(belly.size()), 100));
    cells.push_back(rounded_to(time_s.median(), 10));
    return cells;
  }
};

/// Names of what values() adds, behind those of its first cells.
inline std::vector<std::string> tally_columns(std::vector<std::string> first) {
  for (const char* name : {"reached", "tipped", "refused", "refused late", "other", "pitch rate deg/s",
                           "vertical m/s2", "belly touches", "time s"})
    first.emplace_back(name);
  return first;
}

}  // namespace sortie::bench
