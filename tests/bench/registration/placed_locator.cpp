// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/placed_locator.hpp"

#include <algorithm>

namespace sortie::bench {
namespace {

constexpr int kScansOfMap = 6;
constexpr int kRefusals = 60;
constexpr rt::Nanoseconds kBetween_ns = 200'000'000;

rt::PointScan view(const std::vector<rt::ScanPoint>& points, rt::Nanoseconds stamp_ns) {
  rt::PointScan scan;
  scan.header.stamp_ns = stamp_ns;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

}  // namespace

PlacedLocator::PlacedLocator(const Hall& hall, testing::Draws& draws, bool forgets)
    : memory_(std::size_t{24} << 20),
      arena_(memory_),
      locator_(mapping::RegistrationConfig{}, arena_),
      placed_(locator_) {
  for (int i = 0; i < kScansOfMap; ++i) {
    const PlacedScan scan = hall.scan(draws);
    stamp_ns_ += kBetween_ns;
    (void)locator_.locate(view(scan.points, stamp_ns_), {true, scan.pose, 0.02, 0.005});
  }
  for (int i = 0; forgets && i < kRefusals; ++i) {
    stamp_ns_ += kBetween_ns;
    (void)locator_.locate(view({}, stamp_ns_), {});
  }
  stamp_ns_ += kBetween_ns;
  placed_ = locator_;
  placed_memory_.assign(memory_.begin(), memory_.begin() + static_cast<std::ptrdiff_t>(arena_.used_bytes()));
}

Trial PlacedLocator::offer(const PlacedScan& scan, const mapping::RigidPose& start) {
  Trial trial;
  const double begin = step_cpu_ms();
  trial.located = locator_.locate(view(scan.points, stamp_ns_), {true, start, 10.0, 10.0});
  trial.ms = step_cpu_ms() - begin;
  locator_ = placed_;
  std::copy(placed_memory_.begin(), placed_memory_.end(), memory_.begin());
  return trial;
}

}  // namespace sortie::bench
