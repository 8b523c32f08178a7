// SPDX-License-Identifier: BSD-3-Clause
// A simulated source of position and heading, such as a map matcher: sampled, noisy, late and with losses.
#pragma once

#include <cstdint>

#include "hil/random.hpp"
#include "hil/uav/multirotor_dynamics.hpp"
#include "rt/fixed_vector.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::hil {

/// The source.
struct PoseSourceConfig {
  rt::Nanoseconds period_ns{50'000'000};
  double position_sigma_m{0.01};  ///< each axis
  double yaw_sigma_rad{0.01};
  rt::Nanoseconds delay_ns{50'000'000};         ///< mean
  rt::Nanoseconds delay_spread_ns{10'000'000};  ///< uniform on both sides of the mean
  double loss{0.02};
  double outlier{0.0};         ///< share of fixes that are far off
  double outlier_size_m{2.0};  ///< how far
};

/// Turns true poses into fixes that come out later. Deterministic by seed; the draws a fix do not depend on
/// what is lost. No heap.
class PoseSource {
 public:
  PoseSource(const PoseSourceConfig& config, std::uint64_t seed)
      : config_(config), random_(seed, 0x706f7365) {}

  /// Nothing is measured from `from_ns` up to `to_ns`.
  void black_out(rt::Nanoseconds from_ns, rt::Nanoseconds to_ns) {
    dark_from_ns_ = from_ns;
    dark_to_ns_ = to_ns;
  }

  /// Shows the truth of this moment; a fix is taken whenever a period is over. Call at least once a period.
  void observe(rt::Nanoseconds now_ns, const MultirotorState& truth);

  /// The oldest fix that has arrived by `now_ns`. False when there is none. Call until false.
  bool take(rt::Nanoseconds now_ns, rt::UavFix& fix);

  std::uint64_t lost() const { return lost_; }

 private:
  struct Late {
    rt::Nanoseconds arrival_ns{};
    rt::UavFix fix;
  };

  PoseSourceConfig config_;
  Random random_;
  rt::FixedVector<Late, 32> late_;
  rt::Nanoseconds next_ns_{};
  rt::Nanoseconds dark_from_ns_{};
  rt::Nanoseconds dark_to_ns_{};
  std::uint64_t lost_{};
};

}  // namespace sortie::hil
