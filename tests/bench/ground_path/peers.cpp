// SPDX-License-Identifier: BSD-3-Clause
// The ground planner beside OMPL's optimal planners and exhaustive search.
#include <cmath>

#include "tests/bench/ground_path/ground_parts.hpp"
#include "tests/bench/ground_path/ompl_drives.hpp"
#include "tests/planner/ground_twin.hpp"

namespace sortie::bench {
namespace {

constexpr std::int32_t kCellMm = 100;
constexpr double kNear = 1.05;       // of the optimum
constexpr double kConverged = 1.01;  // of what a peer has at its end

// What one peer did on all halls.
struct PeerRounds {
  const char* name;
  OmplPlanner which;
  Rounds first_ms;
  Rounds converged_ms;
  Rounds final_over_optimum;
  Rounds ours_over_theirs;  // our ms to 1.05 of the optimum over its ms to convergence
  std::uint64_t found{};
};

void ask_peer(PeerRounds& peer, planner::test::OwnedGround& ground, const planner::GroundPose& start,
              const planner::GroundPose& goal, double seconds, double ours_ms, double optimum_s) {
  const auto steps = run_ompl(peer.which, ground, start, goal, seconds);
  if (steps.empty()) return;
  ++peer.found;
  peer.first_ms.add(steps.front().ms);
  const double converged = reached_ms(steps, kConverged * steps.back().cost_s);
  peer.converged_ms.add(converged);
  peer.final_over_optimum.add(steps.back().cost_s / optimum_s);
  peer.ours_over_theirs.add(ours_ms / converged);
}

// What all halls came to.
struct HallRounds {
  PeerRounds peers[2] = {{"OMPL RRT*", OmplPlanner::rrt_star, {}, {}, {}, {}, 0},
                         {"OMPL BIT*", OmplPlanner::bit_star, {}, {}, {}, {}, 0}};
  Rounds first_ms;
  Rounds near_ms;
  Rounds proved_ms;
  Rounds slice_ms;
  Rounds whole_ms;
  std::uint64_t ways{};
  std::uint64_t asked{};
  std::uint64_t agreed{};
};

void ask_hall(const GroundHall& hall, double seconds, HallRounds& all) {
  planner::test::OwnedGround ground(hall_config(hall, kCellMm), hall_room());
  lay_out(hall, ground);
  const planner::GroundPose start = hall_start(hall, kCellMm);
  const planner::GroundPose goal = hall_goal(hall, kCellMm);
  const GroundCourse ours = run_course(ground, start, goal);
  const double before = ground_cpu_ms();
  planner::test::GroundTwin twin(ground);
  const std::uint64_t optimum = twin.optimum(start, goal);
  all.whole_ms.add(ground_cpu_ms() - before);
  ++all.asked;
  const bool proved = ours.state == planner::GroundPathState::proved;
  const bool exists = optimum != planner::test::GroundTwin::kNoWay;
  all.agreed += proved == exists && (!proved || optimum == ground.path.cost()) ? 1 : 0;
  if (!proved || ours.steps.empty()) return;
  ++all.ways;
  const double optimum_s = ours.steps.back().cost_s;
  all.first_ms.add(ours.steps.front().ms);
  all.near_ms.add(reached_ms(ours.steps, kNear * optimum_s));
  all.proved_ms.add(ours.end_ms);
  all.slice_ms.add(ours.worst_slice_ms);
  if (!ompl_drives_missing().empty()) return;
  for (PeerRounds& peer : all.peers)
    ask_peer(peer, ground, start, goal, seconds, all.near_ms.values().back(), optimum_s);
}

// Beside exhaustive search.
void add_answers(const HallRounds& all, Report& report) {
  Figure same;
  same.group = "peers";
  same.what = "halls with the exhaustive search's answer and cost";
  same.n = all.asked;
  same.ours = spread(static_cast<double>(all.agreed));
  set_goal(same, "all", all.agreed == all.asked);
  report.add(same);
  Figure whole;
  whole.group = "peers";
  whole.what = "CPU time to 1.05 of the optimum, exhaustive search's whole";
  whole.unit = "ms";
  whole.n = all.near_ms.size();
  whole.ours = spread(all.near_ms);
  whole.peer = "Dijkstra over all poses";
  whole.theirs = spread(all.whole_ms);
  report.add(whole);
}

// Beside OMPL, a row each.
void add_peers(const HallRounds& all, Report& report) {
  Json rows = Json::array();
  rows.push_back({"ours", all.ways, all.first_ms.median(), all.near_ms.median(), all.near_ms.high(), 1.0});
  for (const PeerRounds& peer : all.peers) {
    if (peer.found == 0) {
      report.skip(peer.name, ompl_drives_missing().empty() ? "it found no way" : ompl_drives_missing());
      continue;
    }
    Figure time;
    time.group = "peers";
    time.what = "CPU time to 1.05 of the optimum, the peer's to 1.01 of its last cost";
    time.unit = "ms";
    time.n = peer.found;
    time.ours = spread(all.near_ms);
    time.peer = peer.name;
    time.theirs = spread(peer.converged_ms);
    time.ratio = spread(peer.ours_over_theirs);
    set_goal(time, "<= 1/10", peer.ours_over_theirs.median() <= 0.1);
    report.add(time);
    rows.push_back({peer.name, peer.found, peer.first_ms.median(), peer.converged_ms.median(),
                    peer.converged_ms.high(), peer.final_over_optimum.median()});
  }
  report.add_table("peers",
                   {"planner", "ways", "first way ms", "converged ms", "worst ms", "cost over our optimum"},
                   rows);
}

}  // namespace

void measure_ground_peers(const GroundSettings& settings, Report& report) {
  HallRounds all;
  seed_ompl_drives(1);
  for (std::uint64_t i = 0; i < settings.maps; ++i)
    ask_hall(draw_hall(static_cast<std::uint32_t>(settings.seed + i)), settings.seconds, all);
  if (all.ways == 0) {
    report.skip("the ground planner's halls", "none of them can be crossed");
    return;
  }
  add_answers(all, report);
  add_peers(all, report);
  report.add_table("peers", {"ours", "median ms", "worst ms"},
                   {{"first way", all.first_ms.median(), all.first_ms.high()},
                    {"within 1.05 of the optimum", all.near_ms.median(), all.near_ms.high()},
                    {"proved to be the optimum", all.proved_ms.median(), all.proved_ms.high()},
                    {"longest slice of 500 units", all.slice_ms.median(), all.slice_ms.high()}});
  if (ompl_drives_missing().empty()) report.note("peers", ompl_drives_settings());
  report.note(
      "peers",
      "Ours begins with nothing judged: prices, distances and search are in its time. Converged: ours within "
      "1.05 of the optimum, a peer within 1.01 of what it had at its end.");
}

}  // namespace sortie::bench
