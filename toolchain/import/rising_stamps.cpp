// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/import/rising_stamps.hpp"

#include <algorithm>
#include <limits>

namespace sortie::toolchain {

std::vector<bool> longest_rise(std::span<const rt::Nanoseconds> stamps_ns) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> ends;  // ends[k]: where the row of k + 1 stamps with the lowest end ends
  std::vector<std::size_t> before(stamps_ns.size(), kNone);
  for (std::size_t i = 0; i < stamps_ns.size(); ++i) {
    const auto place =
        std::upper_bound(ends.begin(), ends.end(), stamps_ns[i],
                         [&](rt::Nanoseconds stamp, std::size_t end) { return stamp < stamps_ns[end]; });
    if (place != ends.begin()) before[i] = *(place - 1);
    if (place == ends.end()) {
      ends.push_back(i);
    } else {
      *place = i;
    }
  }
  std::vector<bool> rises(stamps_ns.size(), false);
  for (std::size_t i = ends.empty() ? kNone : ends.back(); i != kNone; i = before[i]) rises[i] = true;
  return rises;
}

}  // namespace sortie::toolchain
