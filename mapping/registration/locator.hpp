// SPDX-License-Identifier: BSD-3-Clause
// The robot's place on a map that grows with it: each scan is matched to the scans before, and the odometry,
// which stays smooth, hangs on the map by one transform.
#pragma once

#include <cstdint>

#include "mapping/registration/level_pose.hpp"
#include "mapping/registration/scan_registration.hpp"
#include "mapping/registration/seen_space.hpp"
#include "mapping/registration/surfel_map.hpp"
#include "mapping/registration/tie_watch.hpp"
#include "rt/samples.hpp"

namespace sortie::mapping {

/// Whether a scan's pose is believed, and why not.
enum class LocateVerdict : std::uint8_t {
  none = 0,  ///< no scan yet
  first,     ///< the first scan: the map begins with it
  accepted,
  few_returns,   ///< too few that could be matched
  little_share,  ///< too few of them lie on the map's surfaces
  crossed,       ///< rays go through surfaces of the map, or returns stand where the scan before saw nothing
  ambiguous,     ///< another pose does as well
  far_from_prior,  ///< outside what the odometry leaves possible
  unheld,          ///< nothing holds the pose
  new_place,  ///< hardly any of it is on the map yet: the odometry's pose is taken, and the map grows by it
  unplaced,   ///< where the robot is on the kept map is not known: nothing was matched
};
const char* to_string(LocateVerdict verdict);
/// Whether the scan went into the map.
constexpr bool is_placed(LocateVerdict verdict) {
  return verdict == LocateVerdict::first || verdict == LocateVerdict::accepted ||
         verdict == LocateVerdict::new_place;
}

/// Scans by verdict, in the order of the verdicts. in = all others.
struct LocateCounts {
  std::uint64_t in{};
  std::uint64_t first{};
  std::uint64_t accepted{};
  std::uint64_t few_returns{};
  std::uint64_t little_share{};
  std::uint64_t crossed{};
  std::uint64_t ambiguous{};
  std::uint64_t far_from_prior{};
  std::uint64_t unheld{};
  std::uint64_t new_place{};
  std::uint64_t unplaced_on_map{};
  std::uint64_t recovered{};  ///< of the accepted: found from another start, or where the odometry jumped to
  SORTIE_FIELDS(in, first, accepted, few_returns, little_share, crossed, ambiguous, far_from_prior, unheld,
                new_place, unplaced_on_map, recovered)
};

/// A direction in space that the scan says little about.
struct WeakDirection {
  double axis_map[3]{};  ///< unit vector
  double sigma{};        ///< standard deviation along it (m) or about it (rad), prior included
  SORTIE_FIELDS(axis_map, sigma)
};

/// Where a scan was taken.
struct Located {
  rt::Nanoseconds stamp_ns{};
  LocateVerdict verdict{LocateVerdict::none};
  RigidPose T_map_odom;  ///< of the newest accepted scan
  /// Of this scan; where it was refused, the odometry's, or without any that of the scan before.
  RigidPose T_map_sensor;
  /// Of T_map_sensor: (position in map, rotation in sensor), row-major, m^2 and rad^2. Of a scan that was not
  /// accepted it is the odometry's, 10 m and 10 rad where there is none.
  double covariance[36]{};
  double share{};              ///< of the returns, on the map's surfaces
  double known{};              ///< of the returns, in cells that have a surface
  double crossed{};            ///< of the rays: through surfaces of the map
  double inside{};             ///< of the returns: where the scan before saw nothing
  std::uint32_t returns{};     ///< that were matched
  std::uint32_t steps{};       ///< of work, each over at most `returns` returns
  std::uint32_t weak_moves{};  ///< directions that the scan does not hold; at most 3
  std::uint32_t weak_turns{};
  WeakDirection weak_move[3];
  WeakDirection weak_turn[3];
  LocateCounts counts;
  SORTIE_FIELDS(stamp_ns, verdict, T_map_odom, T_map_sensor, covariance, share, known, crossed, inside,
                returns, steps, weak_moves, weak_turns, weak_move, weak_turn, counts)
};

/// What is known of the sensor's pose before its scan.
struct OdometryHint {
  bool known{};  ///< false: no odometry; the motion of the scan before is taken to go on
  RigidPose T_odom_sensor;
  double sigma_move_m{0.05};  ///< of the motion since the scan before
  double sigma_turn_rad{0.02};
};

/// Places scans. All memory is taken from the arena; no heap, no lock, work bounded by a fixed number of
/// steps. The same bits whatever the order of a scan's returns; arithmetic of rt/math alone.
class Locator {
 public:
  Locator(const RegistrationConfig& config, rt::Arena& arena, const RegistrationMemory& memory = {})
      : config_(config),
        registration_(config, arena, memory),
        seen_(arena.make_array<float>("seen_space", SeenSpace::kDirections), config.planar) {}

  /// The place of a scan whose returns are as of one moment, sensor frame. An accepted scan becomes part of
  /// the map. Odometry that is not finite, no rotation, or as good as sure counts as none. In the plane
  /// T_map_odom has neither height nor tilt: the odometry's are the map's.
  const Located& locate(const rt::PointScan& scan, const OdometryHint& hint);
  const Located& located() const { return located_; }
  /// A scan has a place on the map. Until then nothing is known of any motion.
  bool has_begun() const { return before_ns_ != kNever; }

  /// A kept map is there, and nobody has said where on it the robot is.
  bool is_unplaced() const { return anchor_ == Anchor::unplaced; }

  /// Begins anew with a kept map. Scans are then `unplaced` until place() says where the robot is. Set-up
  /// only. Where the map is not taken there is none, as in the beginning.
  SurfelMapResult load(std::span<const std::uint8_t> map);
  /// Where the sensor was on the map when `odometry` was: ties the odometry to the map as an accepted scan
  /// does. What this is worth the next scan says: it is matched from there, and from other starts, too, and
  /// only a scan that the map knows is taken for the robot's place; until one is, place() may be called
  /// again. `covariance`: of (position in map, rotation in sensor), row-major, m^2 and rad^2. not_finite,
  /// out_of_range: no pose, or no covariance; nothing is changed. No map was loaded: not_supported.
  Status place(const RigidPose& T_map_sensor, const double (&covariance)[36], const OdometryHint& odometry);
  /// Takes back what place() said, as long as no scan has said so: `unplaced` again.
  void take_back();
  const ScanRegistration& registration() const { return registration_; }
  /// The same, for who matches scans to the map between two calls of locate().
  ScanRegistration& registration_to_match() { return registration_; }
  void archive(rt::Archive& archive);

 private:
  const Located& look(const rt::PointScan& scan, const OdometryHint& odometry);
  void look_along_rays(const Match& match);
  bool clear() const;  ///< neither rays through surfaces nor returns in what was seen to be empty
  void conclude(LocateVerdict verdict);
  bool has_map() const { return anchor_ != Anchor::none; }
  PosePrior expect(const OdometryHint& odometry) const;
  PosePrior going_on() const;
  Match match_to_map(const PosePrior& prior, const OdometryHint& odometry);
  bool found_where_it_was(const RigidPose& told, Match& match);
  LocateVerdict judge(const Match& match, const PosePrior& prior, const OdometryHint& odometry) const;
  const Located& refuse(LocateVerdict verdict, const OdometryHint& odometry);
  void accept(const RigidPose& pose, const OdometryHint& odometry);
  void describe(const WeakDirections& weak, const double (&c)[6][6], const rt::Quaternion& q_map_sensor);

  /// What the map hangs on.
  enum class Anchor : std::uint8_t {
    none,      ///< there is no map yet
    unplaced,  ///< a kept map, and the robot somewhere
    told,      ///< a kept map, and the robot where place() says; no scan has said so yet
    held,      ///< scans: the map's own, or those that were found on it
  };
  static constexpr rt::Nanoseconds kNever = -(rt::Nanoseconds{1} << 61);  ///< before_ns_: no scan

  static constexpr double kLongestGap = 3.0;  ///< times the last interval: no motion goes on for longer

  static constexpr double kNeverUsual = 2.0;   ///< a share that no match has: all starts are tried
  static constexpr double kHardlyAny = 0.005;  ///< of the returns
  /// Of the returns, on the map, without odometry, after a scan that was refused.
  static constexpr double kLeastAfterRefused = 0.8;
  static constexpr double kForget = 0.9;  ///< of the usual share, a scan that is refused
  static constexpr double kYoung = 0.5;   ///< a usual share: the map is thin, or was left behind
  /// Of the returns, in cells that have a surface: what a place needs that was found from another start than
  /// the expected one. With less of it known, one of 3,000 scans of other halls was taken.
  static constexpr double kLeastElsewhere = 0.4;
  static constexpr double kLeastOfUsual = 0.7;  ///< of the share of the scan before

  RegistrationConfig config_;
  ScanRegistration registration_;
  SeenSpace seen_;  ///< of the newest accepted scan
  Located located_;
  Anchor anchor_{Anchor::none};
  double told_move_m_{};  ///< standard deviations of what place() said
  double told_turn_rad_{};
  OutOfPlane left_out_;  ///< in the plane: of this scan's pose; all poses below have none
  bool tied_{};          ///< the odometry's place on the map is known: an accepted scan came with some
  RigidPose newest_;     ///< T_map_sensor of the two newest accepted scans
  RigidPose before_;
  rt::Nanoseconds newest_ns_{};
  rt::Nanoseconds before_ns_{kNever};
  double usual_share_{};
  TieWatch jumped_;
};

}  // namespace sortie::mapping
