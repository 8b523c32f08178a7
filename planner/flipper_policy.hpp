// SPDX-License-Identifier: BSD-3-Clause
// Which flipper angles and which speed now, for what is seen and not seen of the ground ahead.
#pragma once

#include "planner/flipper_decision.hpp"
#include "planner/flipper_search.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

/// When input is too old, and how long each way out is tried.
struct FlipperPolicyConfig {
  FlipperSearchConfig search{};
  double lead_m{0.1};     ///< the flippers are there before the vehicle has gone so far
  double there_rad{0.1};  ///< flippers so near to what was asked are there
  double creep_m_s{0.05};
  double feel_rad{-0.5};     ///< the leading flippers go down to this angle to feel
  double map_off_m{0.15};    ///< a map whose ground is so far from under the vehicle is not believed
  double steepest_rad{1.0};  ///< pitch or roll beyond it: stop
  rt::Nanoseconds map_age_ns{500 * rt::kNanosecondsPerMillisecond};
  rt::Nanoseconds attitude_age_ns{200 * rt::kNanosecondsPerMillisecond};
  rt::Nanoseconds flipper_age_ns{300 * rt::kNanosecondsPerMillisecond};
  rt::Nanoseconds look_ns{2 * rt::kNanosecondsPerSecond};
  rt::Nanoseconds feel_ns{3 * rt::kNanosecondsPerSecond};
  rt::Nanoseconds creep_ns{10 * rt::kNanosecondsPerSecond};
  rt::Nanoseconds late_ns{5 * rt::kNanosecondsPerSecond};
  rt::Nanoseconds stall_ns{5 * rt::kNanosecondsPerSecond};  ///< told to go and not 2 cm on in that time: stop
};

/// Decides 20 times a second, say. A choice of flippers is taken where the probability of a margin or
/// clearance below its limit, over the filled grounds at all places ahead, is at most
/// FlipperSearchConfig::limit. Where no choice is: the missing cells are looked at, then felt, then crept up
/// to, each for a limited time and the last two only where the first 0.1 m is safe; else it stops and says
/// so. Where nothing is missing it stops at once. A way out that was tried is not tried again before a choice
/// was safe or the direction changed.
///
/// A mirrored world, pose, arc and flippers give the mirrored angles to the last bit. About 1.1 MB; no heap,
/// no clock. Cost: FlipperSearchConfig::units rests of PostureSolver at most, and the look at the window.
class FlipperPolicy {
 public:
  FlipperPolicy(const PostureVehicle& vehicle, const FlipperPolicyConfig& config);

  /// ok; that of FlipperSearch::usable(); out_of_range, not_finite for a setting.
  Status usable() const { return usable_; }

  /// Status: ok; usable(); not_finite: any number of the input; out_of_range: |speed| above 5 m/s, |turn|
  /// above 10 rad/s, an angle above 100 rad, a place beyond 100 km or a view that PostureSolver does not
  /// take; time_repeated, time_backwards. Nothing is changed then.
  Status decide(const HeightView& view, const FlipperInput& input, FlipperDecision& decision);

  const FlipperCounters& counters() const { return counters_; }
  const FlipperSearch& searched() const { return search_; }

  void archive(rt::Archive& archive);

 private:
  /// Which way out is being tried.
  enum class Stage : std::uint8_t { none, late, stuck, look, feel, creep, stop, stalled };

  void enter(Stage stage, rt::Nanoseconds now_ns);
  bool fall_back(const FlipperInput& input, FlipperDecision& decision);
  void go(const FlipperInput& input, FlipperDecision& decision);
  void way_out(const FlipperInput& input, bool disagrees, FlipperDecision& decision);
  void watch_progress(const FlipperInput& input, FlipperDecision& decision);
  void ask(const FlipperSet& angles, FlipperDecision& decision);

  FlipperPolicyConfig config_;
  FlipperSearch search_;
  Status usable_{Status::ok};
  FlipperFound found_;
  FlipperCounters counters_;
  FlipperSet before_;  ///< asked last
  bool has_before_{};
  bool started_{};
  bool backward_{};
  Stage stage_{Stage::none};
  rt::Nanoseconds since_ns_{};
  rt::Nanoseconds stamp_ns_{};
  double from_x_m_{}, from_y_m_{}, from_yaw_rad_{};  ///< where it was last seen to move
  rt::Nanoseconds moved_ns_{};
};

}  // namespace sortie::planner
