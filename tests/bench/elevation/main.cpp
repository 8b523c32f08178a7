// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-elevation: the elevation map beside elevation_mapping's cell filter, over a simulated climb:
// time a scan, and error over run time by size of a cell and by rate. Prints one JSON object; `sortie bench
// elevation` runs it and shows the tables.
#include <algorithm>
#include <memory>

#include "rt/posix/clock.hpp"
#include "tests/bench/elevation/peer_filter.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/figures.hpp"
#include "tests/bench/report/parts.hpp"
#include "tests/mapping/elevation_climb.hpp"
#include "tests/mapping/elevation_twin.hpp"

namespace sortie::bench {
namespace {

struct ElevationSettings {
  std::uint64_t seed{1};
  double way_m{20};
};

// What a drive took and how wrong the map was, relative to the robot.
struct DriveResult {
  Rounds ms;  // a scan
  tests::ClimbVerdict verdict;
};

double ms_since(rt::Nanoseconds begin) {
  return static_cast<double>(rt::posix::thread_cpu_now() - begin) * 1e-6;
}

// Edges of a map that has one height a cell: it is taken for both surfaces.
template <class Span>
void judge(const hil::World& world, const tests::ClimbScan& scan, double edge_m, const Span& span,
           DriveResult& result) {
  tests::judge_climb(world, scan.way_m, 4.0, edge_m, scan.height_error_m, span, result.verdict);
}

DriveResult drive_own(const hil::World& world, const std::vector<tests::ClimbScan>& scans,
                      const mapping::ElevationConfig& config, std::size_t judged_every) {
  DriveResult result;
  tests::OwnedElevation owned(config);
  double way_m = 0;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const tests::ClimbScan& scan = scans[k];
    const rt::Nanoseconds begin = rt::posix::thread_cpu_now();
    (void)tests::feed_climb(owned.map, scan, scan.way_m - way_m, {}, static_cast<rt::Nanoseconds>(k));
    result.ms.add(ms_since(begin));
    way_m = scan.way_m;
    if (k % judged_every != 0) continue;
    const double asker_m = scan.pose.p_world_sensor_m.z - 0.5;
    const auto span = [&](double x, double y, double& low, double& high) {
      const mapping::GroundSpan found = owned.map.view().ground_at(x, y, asker_m);
      low = found.low_m;
      high = found.high_m;
      return found.state >= mapping::GroundState::measured;
    };
    judge(world, scan, config.cell_mm * 1e-3, span, result);
  }
  return result;
}

DriveResult drive_peer(const hil::World& world, const std::vector<tests::ClimbScan>& scans,
                       const PeerFilterConfig& config, std::size_t judged_every, bool with_motion) {
  DriveResult result;
  PeerFilter filter(config);
  const tests::ClimbErrors errors;
  double way_m = 0;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const tests::ClimbScan& scan = scans[k];
    rt::PointScan view = tests::scan_of(scan.points, 0);
    const auto moved_m2 =
        static_cast<float>(errors.drift_m_per_root_m * errors.drift_m_per_root_m * (scan.way_m - way_m));
    const rt::Nanoseconds begin = rt::posix::thread_cpu_now();
    filter.move(scan.pose.p_world_sensor_m.x, scan.pose.p_world_sensor_m.y);
    if (with_motion) filter.predict(moved_m2);
    filter.add(view, scan.pose, scan.way_m / 0.4);
    result.ms.add(ms_since(begin));
    way_m = scan.way_m;
    if (k % judged_every != 0) continue;
    const auto span = [&](double x, double y, double& low, double& high) {
      const bool found = filter.height(x, y, high);
      low = high;
      return found;
    };
    judge(world, scan, config.cell_m, span, result);
  }
  return result;
}

void measure_scans(const ElevationSettings& settings, Report& report) {
  const auto world = std::make_unique<hil::World>();
  tests::build_climb(*world);
  const auto scans = tests::drive_climb(*world, settings.seed, settings.way_m);
  std::uint64_t points = 0;
  for (const tests::ClimbScan& scan : scans) points += scan.points.size();
  const DriveResult own = drive_own(*world, scans, {}, scans.size());
  mapping::ElevationConfig third;
  third.ray_stride = 3;
  const DriveResult thinned = drive_own(*world, scans, third, scans.size());
  mapping::ElevationConfig without;
  without.ray_stride = 0;
  const DriveResult heights = drive_own(*world, scans, without, scans.size());
  const DriveResult peer = drive_peer(*world, scans, {}, scans.size(), true);
  const DriveResult peer_alone = drive_peer(*world, scans, {}, scans.size(), false);
  const std::string name = "elevation_mapping's filter, made again";
  const auto figure = [&](const std::string& what, const DriveResult& ours, const DriveResult& theirs) {
    Figure line{"scan", what, "ms", scans.size(), spread(ours.ms.median()), name, {}, {}, {}, {}};
    line.theirs = spread(theirs.ms.median());
    line.ratio = spread(theirs.ms.median() / ours.ms.median());
    return line;
  };
  Figure whole = figure("a scan, with all its rays", own, peer);
  set_goal(whole, "<= 1 ms", own.ms.median() <= 1.0);
  report.add(whole);
  report.add(figure("a scan, with every third ray", thinned, peer));
  Figure alike = figure("a scan, heights alone", heights, peer);
  set_goal(alike, ">= 3 times as fast", peer.ms.median() >= 3 * heights.ms.median());
  report.add(alike);
  report.add(figure("a scan, heights alone, no motion", heights, peer_alone));
  report.note("scan", "Scans have " + std::to_string(points / std::max<std::size_t>(1, scans.size())) +
                          " returns on average, the slowest took " + std::to_string(own.ms.high()) +
                          " ms. 256 x 256 cells of 5 cm. The peer adds motion to every cell at each scan; "
                          "its check of sight lines and its fusion over neighbours are left out.");
}

void measure_sweep(const ElevationSettings& settings, Report& report) {
  const auto world = std::make_unique<hil::World>();
  tests::build_climb(*world);
  Json rows = Json::array();
  const auto row = [&](const std::string& whose, int cell_mm, int every, std::uint32_t returns,
                       const DriveResult& found) {
    const tests::ClimbVerdict& v = found.verdict;
    const double unknown = static_cast<double>(v.unknown);
    const double all = unknown + static_cast<double>(v.flat) + 0.5 * static_cast<double>(v.edge);
    rows.push_back({whose, cell_mm, 10.0 / every, returns, found.ms.median(), found.ms.high(),
                    1e3 * v.flat_rms_m(), 1e3 * v.edge_rms_m(), unknown / all});
  };
  struct Cell {
    int cell_mm;
    int every;
    std::uint32_t returns;
  };
  constexpr Cell kCells[] = {{25, 1, 9000}, {50, 1, 9000},  {100, 1, 9000}, {200, 1, 9000},
                             {50, 2, 9000}, {50, 10, 9000}, {50, 1, 3000},  {50, 1, 1200}};
  for (const Cell& cell : kCells) {
    const auto scans =
        tests::drive_climb(*world, settings.seed, settings.way_m, {}, cell.every, cell.returns);
    const auto judged = static_cast<std::size_t>(std::max(1, 10 / cell.every));
    mapping::ElevationConfig config;
    config.cell_mm = cell.cell_mm;
    row("ours", cell.cell_mm, cell.every, cell.returns, drive_own(*world, scans, config, judged));
    PeerFilterConfig theirs;
    theirs.cell_m = cell.cell_mm * 1e-3;
    row("elevation_mapping's", cell.cell_mm, cell.every, cell.returns,
        drive_peer(*world, scans, theirs, judged, true));
  }
  report.add_table("sweep",
                   {"filter", "cell mm", "scans/s", "rays a scan", "ms p50", "ms max", "RMS mm",
                    "RMS of edges mm", "not known"},
                   rows);
  report.note(
      "sweep",
      "Cells from 0.6 m behind to 4 m ahead, 1 m wide, asked ten times as seldom as scans come, "
      "heights relative to the robot. Of edges both surfaces count; the peer has one height for both.");
}

constexpr BenchPart<ElevationSettings> kParts[] = {{"scan", measure_scans}, {"sweep", measure_sweep}};

int run(int argc, char** argv) {
  ElevationSettings settings;
  std::string only;
  read_arguments(argc, argv,
                 {{"--seed", settings.seed, 0, 1e9}, {"--way", settings.way_m, 1, 20}, {"--only", only}});
  print_parts<ElevationSettings>(kParts, settings, only,
                                 {{"seed", settings.seed}, {"way_m", settings.way_m}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-elevation",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
