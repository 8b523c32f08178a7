// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/uav/ompl_ways.hpp"

#ifdef SORTIE_PEER_OMPL
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include "tests/bench/uav/pilot_cost.hpp"
#endif

namespace sortie::bench {

#ifdef SORTIE_PEER_OMPL

namespace ob = ompl::base;

std::string ompl_missing() { return {}; }

std::string ompl_settings() {
  return "OMPL's RRTConnect with its default range (a fifth of the space), simplifySolution() as it comes, "
         "motions "
         "checked each half voxel in the same free voxels, 10 s at most.";
}

void seed_ompl(std::uint32_t seed) {
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  ompl::RNG::setSeed(seed);
}

PeerWay ompl_way(const planner::FlightMap& map, const planner::Voxel3& start, const planner::Voxel3& goal) {
  const planner::FlightMapConfig& c = map.config();
  auto space = std::make_shared<ob::RealVectorStateSpace>(3);
  ob::RealVectorBounds bounds(3);
  const double origin[3] = {c.origin_m.x, c.origin_m.y, c.origin_m.z};
  const std::int32_t count[3] = {c.nx, c.ny, c.nz};
  for (unsigned i = 0; i < 3; ++i) {
    bounds.setLow(i, origin[i]);
    bounds.setHigh(i, origin[i] + c.voxel_m * count[i]);
  }
  space->setBounds(bounds);
  const auto place = [&map, &space](const planner::Voxel3& v) {
    ob::ScopedState<ob::RealVectorStateSpace> state(space);
    const rt::Vector3 p = map.middle_m(v);
    state[0] = p.x;
    state[1] = p.y;
    state[2] = p.z;
    return state;
  };
  const double before = cpu_us();
  ompl::geometric::SimpleSetup setup(space);
  setup.setStateValidityChecker([&map](const ob::State* state) {
    const double* p = state->as<ob::RealVectorStateSpace::StateType>()->values;
    return map.is_free(map.voxel_at({p[0], p[1], p[2]}));
  });
  space->setLongestValidSegmentFraction(0.5 * c.voxel_m / space->getMaximumExtent());
  setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(setup.getSpaceInformation()));
  setup.setStartAndGoalStates(place(start), place(goal));
  PeerWay way;
  way.found = setup.solve(10.0) == ob::PlannerStatus::EXACT_SOLUTION;
  if (way.found) setup.simplifySolution();
  way.ms = 1e-3 * (cpu_us() - before);
  if (way.found) way.length_m = setup.getSolutionPath().length();
  return way;
}

#else

std::string ompl_missing() { return "OMPL is missing. Cure: apt-get install libompl-dev"; }
std::string ompl_settings() { return {}; }
void seed_ompl(std::uint32_t) {}
PeerWay ompl_way(const planner::FlightMap&, const planner::Voxel3&, const planner::Voxel3&) { return {}; }

#endif

}  // namespace sortie::bench
