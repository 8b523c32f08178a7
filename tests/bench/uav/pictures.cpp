// SPDX-License-Identifier: BSD-3-Clause
// Flights as pictures: a step of a goal, a gust, and a way through a hall from above and from the side.
#include <algorithm>
#include <cmath>

#include "tests/bench/report/picture.hpp"
#include "tests/bench/uav/uav_parts.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::bench {
namespace {

namespace rig = planner::test;

// A goal 1 m away: ours through the profile, Lee as RotorS gets it, raw.
void draw_move(Report& report) {
  Picture picture{
      "bench-uav-move", "moves", "A goal 1 m away at 0 s", "time, s", "x, m", false, false, false, {}};
  const auto add = [&picture](const std::string& vehicle, Pilot pilot, const std::string& name) {
    FlightSetup setup = flight_setup(vehicle);
    setup.pilot = pilot;
    setup.seconds = 5.0;
    setup.judged = [](double time_s) {
      planner::FlatReference r;
      r.p_m = {time_s < 1.0 ? 0.0 : 1.0, 0, 5};
      return r;
    };
    setup.command = [](double time_s, planner::UavControl& control) {
      if (time_s >= 1.0 && time_s < 1.005) (void)control.set_goal({1, 0, 5}, 0);
    };
    Curve curve;
    curve.name = name;
    if (pilot == Pilot::lee) curve.style = "dashed";
    for (const FlightSample& sample : fly(setup).record) {
      if (sample.time_s < 0.8) continue;
      curve.x.push_back(sample.time_s - 1.0);
      curve.y.push_back(sample.p_m.x);
    }
    picture.curves.push_back(curve);
  };
  for (const char* vehicle : {"neo11", "neo9", "firefly"}) add(vehicle, Pilot::ours, vehicle);
  add("neo11", Pilot::lee, "neo11, Lee, raw goal");
  add_picture(report, picture);
}

// The usual flight around its gust.
void draw_gust(Report& report) {
  struct Line {
    Pilot pilot;
    const char* name;
    bool estimated;
  };
  Picture picture{"bench-uav-gust",
                  "gust",
                  "neo11, 5 N from 20 s to 22 s, mass +10 %, noise",
                  "time, s",
                  "error of the position, mm",
                  false,
                  true,
                  false,
                  {}};
  for (const Line& line : {Line{Pilot::lee, "Lee", false},
                           {Pilot::lee_integral, "Lee with integrator", false},
                           {Pilot::ours_unobserved, "ours, no observer", false},
                           {Pilot::ours, "ours", false},
                           {Pilot::ours, "ours on estimates", true}}) {
    FlightSetup setup = usual_flight("neo11", line.pilot, 1.1, 5.0, !line.estimated, 1);
    setup.integral_share_hz = 0.25;
    setup.estimated = line.estimated;
    Curve curve;
    curve.name = line.name;
    if (line.pilot == Pilot::lee || line.pilot == Pilot::lee_integral) curve.style = "dashed";
    for (const FlightSample& sample : fly(setup).record) {
      if (sample.time_s < 18.0 || sample.time_s > 28.0) continue;
      curve.x.push_back(sample.time_s);
      curve.y.push_back(std::max(0.1, 1e3 * sample.error_m));
    }
    picture.curves.push_back(curve);
  }
  add_picture(report, picture);
}

// Outlines of the blocked cells of one layer, as broken lines: x over y (axis 2) or x over z (axis 1).
Curve walls(const planner::FlightMap& map, int across, std::int32_t layer) {
  Curve curve{"blocked", {}, {}, {}, "grey"};
  const planner::FlightMapConfig& c = map.config();
  const double origin[3] = {c.origin_m.x, c.origin_m.y, c.origin_m.z};
  const int up = across == 2 ? 1 : 2;
  const std::int32_t count[3] = {c.nx, c.ny, c.nz};
  const auto blocked = [&](std::int32_t x, std::int32_t v) {
    if (x < 0 || v < 0 || x >= count[0] || v >= count[up]) return false;
    return map.is_blocked(across == 2 ? planner::Voxel3{x, v, layer} : planner::Voxel3{x, layer, v});
  };
  const auto line = [&](double x0, double v0, double x1, double v1) {
    for (const double x : {x0, x1, std::nan("")}) curve.x.push_back(origin[0] + c.voxel_m * x);
    for (const double v : {v0, v1, std::nan("")}) curve.y.push_back(origin[up] + c.voxel_m * v);
  };
  // One line a straight run of edges.
  for (std::int32_t v = 0; v <= count[up]; ++v) {
    for (std::int32_t x = 0, begin = -1; x <= count[0]; ++x) {
      const bool edge = blocked(x, v) != blocked(x, v - 1);
      if (edge && begin < 0) begin = x;
      if (!edge && begin >= 0) {
        line(begin, v, x, v);
        begin = -1;
      }
    }
  }
  for (std::int32_t x = 0; x <= count[0]; ++x) {
    for (std::int32_t v = 0, begin = -1; v <= count[up]; ++v) {
      const bool edge = blocked(x, v) != blocked(x - 1, v);
      if (edge && begin < 0) begin = v;
      if (!edge && begin >= 0) {
        line(x, begin, x, v);
        begin = -1;
      }
    }
  }
  return curve;
}

// neo11 on estimates, in gusts, along a planned way, corner by corner.
void draw_way(Report& report) {
  rig::OwnedMap owned(rig::cube(80, 48, 20, 0.4, 0.2));
  rig::build_hall(owned.map, 3, 3, 12);
  rig::OwnedPath memory(owned.map);
  std::mt19937 random(3);
  const planner::Voxel3 start = rig::any_free(owned.map, random, 2, 10);
  const planner::Voxel3 goal = rig::any_free(owned.map, random, 70, 78);
  (void)memory.path.begin(owned.map, owned.map.middle_m(start), owned.map.middle_m(goal));
  while (memory.path.state() == planner::PathState::running ||
         memory.path.state() == planner::PathState::found)
    (void)memory.path.step(owned.map, 1000);
  const std::vector<rt::Vector3> way(memory.path.waypoints().begin(), memory.path.waypoints().end());
  if (way.size() < 2) return report.skip("the picture of a way", "there is none through the drawn hall");
  FlightSetup setup = flight_setup("neo11");
  setup.plant.ground = false;  // the map's floor is not at height 0
  setup.estimated = true;
  setup.seconds = 10.0 + 2.5 * static_cast<double>(way.size()) + memory.path.length_m() / 1.4;
  setup.judged = [&way](double) {
    planner::FlatReference r;
    r.p_m = way.front();
    return r;
  };
  std::size_t next = 1;
  setup.command = [&way, &next](double, planner::UavControl& control) {
    if (next < way.size() && (next == 1 || rt::norm(control.reference().p_m - way[next - 1]) < 0.02))
      (void)control.set_goal(way[next++], 0.0);
  };
  for (int i = 0; i < 4; ++i) setup.gusts.push_back(diagonal_gust(i % 2 == 0 ? 5.0 : -5.0, 4.0 + 5.0 * i));
  const FlightResult flown = fly(setup);
  double nearest = HUGE_VAL;
  double off = 0.0;
  Curve planned[2];
  Curve track[2];
  for (int view = 0; view < 2; ++view) {
    planned[view].name = "planned";
    planned[view].style = "dashed";
    track[view].name = "flown";
    for (const rt::Vector3& p : way) {
      planned[view].x.push_back(p.x);
      planned[view].y.push_back(view == 0 ? p.y : p.z);
    }
    for (const FlightSample& sample : flown.record) {
      track[view].x.push_back(sample.p_m.x);
      track[view].y.push_back(view == 0 ? sample.p_m.y : sample.p_m.z);
    }
  }
  for (const FlightSample& sample : flown.record) {
    const rt::Vector3 p{sample.p_m.x, sample.p_m.y, sample.p_m.z};
    nearest = std::min(nearest, rig::scaled_distance(owned.map, p));
    double least = HUGE_VAL;
    for (std::size_t i = 1; i < way.size(); ++i) {
      const rt::Vector3 d = way[i] - way[i - 1];
      const double s = std::clamp(rt::dot(p - way[i - 1], d) / rt::dot(d, d), 0.0, 1.0);
      least = std::min(least, rt::norm(p - way[i - 1] - s * d));
    }
    off = std::max(off, least);
  }
  const rt::Vector3 end{flown.record.back().p_m.x, flown.record.back().p_m.y, flown.record.back().p_m.z};
  add_limit(report, "way", "distance to the goal at the end", "m", rt::norm(end - way.back()), 0.05);
  add_limit(report, "way", "greatest distance from the planned way, four gusts of 5 N", "m", off, 0.15);
  Figure touch{"way",
               "least distance of the robot's ellipsoid to what is blocked, 1: it touches",
               "",
               1,
               spread(nearest),
               {},
               {},
               {},
               {},
               {}};
  set_goal(touch, "> 1", nearest > 1.0);
  report.add(touch);
  const planner::Voxel3 layer = owned.map.voxel_at(way[way.size() / 2]);
  for (int view = 0; view < 2; ++view) {
    add_picture(report, {view == 0 ? "bench-uav-top" : "bench-uav-side",
                         "way",
                         view == 0 ? "A way through three walls, from above (walls at one height)"
                                   : "The same from the side (walls in one plane)",
                         "x, m",
                         view == 0 ? "y, m" : "z, m",
                         false,
                         false,
                         true,
                         {walls(owned.map, view == 0 ? 2 : 1, view == 0 ? layer.z : layer.y), planned[view],
                          track[view]}});
  }
}

}  // namespace

void measure_uav_pictures(const UavSettings& settings, Report& report) {
  if (!settings.brief) {
    draw_move(report);
    draw_gust(report);
  }
  draw_way(report);
}

}  // namespace sortie::bench
