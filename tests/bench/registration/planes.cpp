// SPDX-License-Identifier: BSD-3-Clause
// Planes of a cloud, grown from points and kept up to date; and sets of planes registered.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "tests/bench/registration/hall_case.hpp"
#include "tests/bench/registration/pcl_planes.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/scan_peers.hpp"
#include "tests/bench/report/front.hpp"
#include "tests/mapping/cloud_trials.hpp"

namespace sortie::bench {
namespace {

constexpr std::size_t kPoints = 290'000;
constexpr std::uint32_t kCells = 65'536;  ///< more than there are
constexpr std::size_t kView = 4096;       ///< points of a scan
constexpr double kNear_m = 5.0;           ///< of the new scan
constexpr rt::Vector3 kFrom{15, 10, 2};

std::vector<rt::Vector3> cloud_of(const std::vector<mapping::Plane>& truth, tests::WorldRandom& random) {
  std::vector<rt::Vector3> points;
  for (const Eigen::Vector3d& p : tests::points_on(truth, kPoints, 0.01, random))
    points.push_back({p.x(), p.y(), p.z()});
  random.shuffle(points);
  return points;
}

using PlaneCells = std::vector<mapping::PlaneCell>;

PlaneCells cells_of(const mapping::SightLayer& layer) {
  PlaneCells cells;
  layer.for_each_plane_cell(layer.by_key(),
                            [&cells](const mapping::PlaneCell& cell) { cells.push_back(cell); });
  return cells;
}

/// Of `now`, those that are not in `before` as they are; both by rising key.
PlaneCells changed(const PlaneCells& before, const PlaneCells& now) {
  PlaneCells out;
  std::size_t at = 0;
  for (const mapping::PlaneCell& cell : now) {
    const auto same_place = [&cell](const mapping::PlaneCell& other) {
      return std::memcmp(other.at, cell.at, sizeof cell.at) == 0;
    };
    // A cell that was there keeps its place in the order; new ones stand between.
    const bool was = at < before.size() && same_place(before[at]);
    if (!was || before[at].count != cell.count) out.push_back(cell);
    if (was) ++at;
  }
  return out;
}

/// Planes of the hall, 2 m^2 and more, that one of `found` lies on to 2 degrees and 3 cm.
template <class Found>
double share_found(const std::vector<mapping::Plane>& truth, const Found& found) {
  int all = 0;
  int seen = 0;
  for (const mapping::Plane& plane : truth) {
    if (plane.area_m2 < 2.0) continue;
    ++all;
    for (const RegionPlane& other : found) {
      if (std::fabs(rt::dot(plane.normal, other.normal)) < 0.9994 ||
          std::fabs(rt::dot(plane.normal, other.middle_m - plane.centroid_m)) > 0.03)
        continue;
      ++seen;
      break;
    }
  }
  return 100.0 * seen / std::max(1, all);
}

struct GrowingRounds {
  Rounds scratch_ms, update_ms, pcl_ms, cells, changed, found, pcl_found;
};

void grow(GrowingRounds& rounds, std::uint64_t seed) {
  tests::WorldRandom random(static_cast<std::uint32_t>(seed));
  tests::HallMaker hall(random, 30, 20, 6);
  hall.shell();
  hall.furnish(29);
  const std::vector<rt::Vector3> points = cloud_of(hall.planes, random);
  std::vector<rt::Vector3> near;
  const rt::Vector3 about{random.between(5, 25), random.between(5, 15), 1};
  for (const rt::Vector3& p : cloud_of(hall.planes, random)) {
    if (rt::norm(p - about) < kNear_m && near.size() < kView) near.push_back(p);
  }
  mapping::SightConfig room = mapping::sight_config(mapping::CloudSensor::laser);
  room.cells = kCells;
  tests::OwnedSight sight(room);
  const auto owned = std::make_unique<tests::OwnedGrowing>(
      mapping::growing_config(mapping::CloudSensor::laser), kCells, 2048);
  const auto insert = [&sight](const std::vector<rt::Vector3>& all) {
    for (std::size_t i = 0; i < all.size(); i += kView)
      (void)sight.layer.insert(std::span(all).subspan(i, std::min(kView, all.size() - i)), kFrom);
  };
  double begin = step_cpu_ms();
  insert(points);
  sight.layer.for_each_plane_cell(sight.layer.by_key(), [&owned](const mapping::PlaneCell& cell) {
    (void)owned->growing.set_cell(cell);
  });
  (void)owned->run_all();
  mapping::PlaneSet set;
  owned->growing.planes(set);
  rounds.scratch_ms.add(step_cpu_ms() - begin);
  std::vector<RegionPlane> found;
  for (std::uint32_t i = 0; i < set.size(); ++i) found.push_back({set[i].centroid_m, set[i].normal});
  rounds.found.add(share_found(hall.planes, found));

  const PlaneCells before = cells_of(sight.layer);
  begin = step_cpu_ms();
  insert(near);
  double update_ms = step_cpu_ms() - begin;
  const PlaneCells of_scan = changed(before, cells_of(sight.layer));
  begin = step_cpu_ms();
  for (const mapping::PlaneCell& cell : of_scan) (void)owned->growing.set_cell(cell);
  (void)owned->run_all();
  update_ms += step_cpu_ms() - begin;
  rounds.update_ms.add(update_ms);
  rounds.cells.add(static_cast<double>(before.size()));
  rounds.changed.add(static_cast<double>(of_scan.size()));
  if (!has_pcl()) return;
  double ms = 0;
  rounds.pcl_found.add(share_found(hall.planes, pcl_planes(points, ms)));
  rounds.pcl_ms.add(ms);
}

void measure_growing(const RegistrationSettings& settings, Report& report) {
  GrowingRounds rounds;
  for (int i = 0; i < std::min(settings.cases_or(10), 100); ++i)
    grow(rounds, settings.seed + static_cast<std::uint64_t>(i));
  Figure scratch;
  scratch.group = "planes";
  scratch.what = "290,000 points of a hall to planes, from scratch";
  scratch.unit = "ms";
  scratch.n = rounds.scratch_ms.size();
  scratch.ours = spread(rounds.scratch_ms);
  Figure found;
  found.group = "planes";
  found.what = "the hall's planes of 2 m^2 and more that are found, to 2 deg and 3 cm";
  found.unit = "%";
  found.n = scratch.n;
  found.ours = spread(rounds.found);
  if (!rounds.pcl_ms.empty()) {
    scratch.peer = found.peer = "PCL region growing";
    scratch.theirs = spread(rounds.pcl_ms);
    scratch.ratio = spread(ratio(rounds.scratch_ms, rounds.pcl_ms));
    found.theirs = spread(rounds.pcl_found);
    found.ratio = spread(ratio(rounds.found, rounds.pcl_found));
  }
  set_goal(scratch, "30 ms at most", rounds.scratch_ms.median() <= 30);
  Figure update;
  update.group = "planes";
  update.what = "a further scan of 4,096 points, planes kept up";
  update.unit = "ms";
  update.n = rounds.update_ms.size();
  update.ours = spread(rounds.update_ms);
  set_goal(update, "3 ms at most", rounds.update_ms.median() <= 3);
  report.add(scratch);
  report.add(update);
  report.add(found);
  report.note("planes",
              "Halls of 30 x 20 x 6 m, 29 planes, 1 cm of noise: " + decimals(rounds.cells.median(), 0) +
                  " cells of 0.4 m in the median, of which a " + "scan within 5 m of a place changes " +
                  decimals(rounds.changed.median(), 0) +
                  ". From scratch: points into cells, planes over them. PCL: normals of 20 "
                  "neighbours, regions over them, one thread.");
}

void measure_sets(const RegistrationSettings& settings, Report& report, std::uint32_t common,
                  std::uint32_t source_only, std::uint32_t target_only, double goal_ms, double share) {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  for (const bool known : {true, false}) {
    Rounds ms;
    tests::PlaneTally tally;
    const int cases = settings.cases_or(200);
    for (int i = 0; i < cases; ++i) {
      tests::WorldRandom random(static_cast<std::uint32_t>(settings.seed) + static_cast<std::uint32_t>(i));
      const tests::PlaneScene scene =
          tests::random_scene(common, source_only, target_only, 1.0, {}, {0.01, 0.004, 0.6}, random);
      const mapping::PlaneEstimate estimate = tests::gps(scene, known, 0.0, random);
      const double begin = step_cpu_ms();
      const mapping::PlaneRegistrationResult result = tests::registered(*registration, scene, estimate);
      ms.add(step_cpu_ms() - begin);
      tally.judge(scene, result);
    }
    Figure figure;
    figure.group = "planes";
    figure.what = std::to_string(common + source_only) + " planes on " +
                  std::to_string(common + target_only) + ", " + std::to_string(common) + " in common, " +
                  (known ? "3 m and 6 deg known" : "nothing known") + ": " + std::to_string(tally.close) +
                  " placed, " + std::to_string(tally.near) + " near, " + std::to_string(tally.wrong) +
                  " wrong, p" + decimals(100 * share, 0);
    figure.unit = "ms";
    figure.n = ms.size();
    figure.ours = {{"value", ms.quantile(share)}, {"low", ms.low()}, {"high", ms.high()}};
    set_goal(figure, decimals(goal_ms, 1) + " ms at most, none wrong",
             ms.quantile(share) <= goal_ms && tally.wrong == 0);
    report.add(figure);
  }
}

}  // namespace

void measure_registration_planes(const RegistrationSettings& settings, Report& report) {
  measure_growing(settings, report);
  measure_sets(settings, report, 16, 13, 8, 0.1, 0.5);
  measure_sets(settings, report, 20, 129, 9, 1.0, 0.99);
}

}  // namespace sortie::bench
