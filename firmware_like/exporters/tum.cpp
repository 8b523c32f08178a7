// SPDX-License-Identifier: BSD-3-Clause
// Stamps are formatted from integers: as doubles they would keep only 0.2 us.
#include "firmware_like/exporters/tum.hpp"

#include <ostream>

#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

std::size_t write_tum(std::ostream& out, std::span<const TimedPose> trajectory) {
  for (const TimedPose& pose : trajectory) {
    out << format_seconds(pose.stamp_ns);
    for (const double x : pose.p) out << ' ' << format_exact(x);
    for (const int i : {1, 2, 3, 0}) out << ' ' << format_exact(pose.q[i]);
    out << '\n';
  }
  return trajectory.size();
}

}  // namespace sortie::firmware
