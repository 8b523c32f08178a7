// SPDX-License-Identifier: BSD-3-Clause
// Stamps are formatted from integers: as doubles they would keep only 0.2 us.
#include "toolchain/export/tum.hpp"

#include <ostream>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

std::size_t write_tum(std::ostream& out, std::span<const firmware::TimedPose> trajectory) {
  for (const firmware::TimedPose& pose : trajectory) {
    out << firmware::format_seconds(pose.stamp_ns);
    for (const double x : pose.p) out << ' ' << firmware::format_exact(x);
    for (const int i : {1, 2, 3, 0}) out << ' ' << firmware::format_exact(pose.q[i]);
    out << '\n';
  }
  return trajectory.size();
}

}  // namespace sortie::toolchain
