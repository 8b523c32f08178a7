// SPDX-License-Identifier: BSD-3-Clause
// A recorded lidar that is carried by hand, without odometry, beside its peers: it turns up to 48 degrees
// from one scan to the next.
#include <cmath>
#include <functional>

#include "mapping/registration/pose_algebra.hpp"
#include "tests/bench/registration/hall_case.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/remade_peers.hpp"
#include "tests/bench/registration/scan_peers.hpp"
#include "tests/bench/report/front.hpp"
#include "tests/bench/report/picture.hpp"
#include "tests/mapping/recorded_scans.hpp"

namespace sortie::bench {
namespace {

constexpr double kKissVoxel_m = 0.5, kRange_m = 50.0;  // the authors' advice for indoors
constexpr double kGicpThinned_m = 0.25;

using Scans = std::vector<tests::RecordedScan>;
/// The pose of a scan, each after the one before.
using Follower = std::function<mapping::RigidPose(const tests::RecordedScan&)>;

struct Walk {
  std::vector<mapping::RigidPose> poses;
  Rounds ms;
};

Walk follow(const Scans& scans, const Follower& follower) {
  Walk walk;
  for (const tests::RecordedScan& scan : scans) {
    const double begin = step_cpu_ms();
    walk.poses.push_back(follower(scan));
    walk.ms.add(step_cpu_ms() - begin);
  }
  return walk;
}

std::vector<mapping::RigidPose> truth_of(const Scans& scans) {
  std::vector<mapping::RigidPose> out;
  for (const tests::RecordedScan& scan : scans)
    out.push_back({scan.pose().p_world_sensor_m, scan.pose().q_world_sensor});
  return out;
}

mapping::RigidPose between(const mapping::RigidPose& a, const mapping::RigidPose& b) {
  return mapping::after(mapping::inverse(a), b);
}

Json row(const char* name, const Walk& walk, const std::vector<mapping::RigidPose>& truth, int& off) {
  Rounds mm, deg;
  double way_m = 0;
  off = 0;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const mapping::RigidPose motion = between(truth[i - 1], truth[i]);
    const PoseError error = pose_error(between(walk.poses[i - 1], walk.poses[i]), motion);
    mm.add(1e3 * error.move_m);
    deg.add(error.turn_deg);
    off += error.within(0.1, 1.0) ? 0 : 1;  // what is not a number is off
    way_m += rt::norm(motion.p);
  }
  const double end_m = rt::norm(
      between(between(truth.front(), truth.back()), between(walk.poses.front(), walk.poses.back())).p);
  return {name,
          mm.size(),
          off,
          decimals(mm.median(), 1),
          decimals(mm.quantile(0.99), 0),
          decimals(deg.median(), 3),
          decimals(deg.quantile(0.99), 2),
          decimals(100 * end_m / way_m, 2) + " %",
          decimals(walk.ms.median(), 1),
          decimals(walk.ms.quantile(0.99), 1),
          decimals(walk.ms.high(), 1)};
}

Curve path(const char* name, const std::vector<mapping::RigidPose>& poses,
           const std::vector<mapping::RigidPose>& truth) {
  Curve curve;
  curve.name = name;
  for (const mapping::RigidPose& pose : poses) {
    const mapping::RigidPose at = mapping::after(truth.front(), between(poses.front(), pose));
    curve.x.push_back(at.p.x);
    curve.y.push_back(at.p.y);
  }
  return curve;
}

PeerPoints points_of(const tests::RecordedScan& scan) {
  PeerPoints out;
  for (const rt::ScanPoint& p : scan.points)
    out.push_back({static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)});
  return out;
}

/// VGICP to the model of all scans so far, from constant motion.
Follower voxel_gicp_follower() {
  struct State {
    VoxelGicp gicp;
    mapping::RigidPose pose, motion;
  };
  return [state = std::make_shared<State>()](const tests::RecordedScan& recorded) {
    PeerPoints scan = one_a_voxel(points_of(recorded), kGicpThinned_m);
    if (!state->gicp.empty()) {
      const mapping::RigidPose expected = mapping::after(state->pose, state->motion);
      const mapping::RigidPose found = state->gicp.align(scan, expected);
      const bool diverged = !std::isfinite(rt::norm(found.p));  // then it goes on as it went
      if (!diverged) state->motion = between(state->pose, found);
      state->pose = diverged ? expected : found;
    }
    for (rt::Vector3& p : scan) p = state->pose.p + rt::rotate(state->pose.q, p);
    state->gicp.add(scan);
    return state->pose;
  };
}

}  // namespace

void measure_registration_walk(const RegistrationSettings& settings, Report& report) {
  const Scans scans = tests::read_rls(settings.data + "/lidar_os64/os64_thin4_000_109.rls");
  if (scans.empty()) return report.skip("the recorded walk", "lidar_os64 is not in " + settings.data);
  const std::vector<mapping::RigidPose> truth = truth_of(scans);
  std::vector<std::byte> memory(std::size_t{32} << 20);
  rt::Arena arena(memory);
  mapping::Locator locator({}, arena);
  Json rows = Json::array();
  Picture picture{"bench-registration-walk",
                  "walk",
                  "A lidar carried by hand, without odometry, from above",
                  "x, m",
                  "y, m",
                  false,
                  false,
                  true,
                  {}};
  picture.curves.push_back(path("reference", truth, truth));
  picture.curves.back().style = "grey";
  const auto add = [&](const char* name, const Follower& follower) {
    const Walk walk = follow(scans, follower);
    int off = 0;
    rows.push_back(row(name, walk, truth, off));
    picture.curves.push_back(path(name, walk.poses, truth));
    return off;
  };
  const int off = add("ours", [&locator](const tests::RecordedScan& scan) {
    return locator.locate(scan.view(), {}).T_map_sensor;
  });
  add("KISS-ICP, made again", [kiss = std::make_shared<KissIcp>(kKissVoxel_m, kRange_m)](
                                  const tests::RecordedScan& scan) { return kiss->follow(points_of(scan)); });
  if (has_pcl()) add("VGICP to the model, made again", voxel_gicp_follower());
  report.add_table("walk",
                   {"who", "pairs", "off by 10 cm or 1 deg", "mm median", "mm p99", "deg median", "deg p99",
                    "end, of the way", "ms a scan median", "p99", "max"},
                   rows);
  add_picture(report, picture);
  Figure figure;
  figure.group = "walk";
  figure.what = "pairs of scans lost";
  figure.unit = "pairs";
  figure.n = scans.size() - 1;
  figure.ours = spread(off);
  set_goal(figure, "none", off == 0);
  report.add(figure);
  report.note(
      "walk",
      "64 rows at 2 Hz, up to 48 degrees between two scans, 39 m. Each from its own pose of the scan "
      "before and constant motion. KISS-ICP with voxels of 0.5 m, VGICP with points thinned to 0.25 m. "
      "The reference is the recording's own: below 1 cm and 0.1 degrees it says nothing.");
}

}  // namespace sortie::bench
