// SPDX-License-Identifier: BSD-3-Clause
// A locator that knows a hall, and can be brought back to that state after every trial.
#pragma once

#include <vector>

#include "tests/bench/registration/hall_case.hpp"

namespace sortie::bench {

/// What a locator made of a scan.
struct Trial {
  mapping::Located located;
  double ms{};  ///< of the thread, the whole call
};

/// The locator as a robot has it, after six scans with good odometry.
class PlacedLocator {
 public:
  /// `forgets`: it was refused so often since that no share is usual any more.
  PlacedLocator(const Hall& hall, testing::Draws& draws, bool forgets);

  /// Offers a scan whose odometry says `start` and claims nothing: 10 m, 10 rad. The state stays as it was.
  Trial offer(const PlacedScan& scan, const mapping::RigidPose& start);

 private:
  std::vector<std::byte> memory_;
  rt::Arena arena_;
  mapping::Locator locator_;
  mapping::Locator placed_;
  std::vector<std::byte> placed_memory_;
  rt::Nanoseconds stamp_ns_{1};
};

}  // namespace sortie::bench
