// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/ground_path/ompl_drives.hpp"

#ifdef SORTIE_PEER_OMPL
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/objectives/StateCostIntegralObjective.h>
#include <ompl/base/spaces/ReedsSheppStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>
#include <cmath>
#endif

namespace sortie::bench {

#ifdef SORTIE_PEER_OMPL

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using Space = ob::ReedsSheppStateSpace;

constexpr double kRadiusM = 0.34;  // of the lattice's tightest curve

double heading_angle(std::int32_t heading) {
  const planner::CellStep step = planner::kHeadingSteps[static_cast<std::size_t>(heading)];
  return std::atan2(static_cast<double>(step.y), static_cast<double>(step.x));
}

// What standing costs, from the same table as ours: the price of the nearest cell and heading.
class Stands {
 public:
  explicit Stands(planner::test::OwnedGround& ground)
      : ground_(ground),
        memory_(planner::StandPrices::bytes_for(ground.config)),
        prices_(ground.config, {planner::test::OwnedGround::price_of, &ground, 0, nullptr}, memory_) {}

  std::uint8_t price(const ob::State* state) const {
    const auto* s = state->as<Space::StateType>();
    const double cells_m = 1e3 / ground_.config.cell_mm;
    const auto x = static_cast<std::int32_t>(std::floor(s->getX() * cells_m));
    const auto y = static_cast<std::int32_t>(std::floor(s->getY() * cells_m));
    if (!ground_.map.is_inside(x, y)) return planner::kBlockedStand;
    std::int32_t best = 0;
    double nearest = 10.0;
    for (std::int32_t h = 0; h < planner::kHeadings; ++h) {
      const double apart = std::abs(std::remainder(s->getYaw() - heading_angle(h), 2 * M_PI));
      if (apart >= nearest) continue;
      nearest = apart;
      best = h;
    }
    std::uint64_t units = 0;
    return prices_.price(ground_.map, x, y, 0, best, units);
  }
  const planner::GroundPathConfig& config() const { return ground_.config; }

 private:
  planner::test::OwnedGround& ground_;
  std::vector<std::uint8_t> memory_;
  mutable planner::StandPrices prices_;
};

// Time at the prices, as ours: each half cell at the price of its middle.
class DriveCost : public ob::OptimizationObjective {
 public:
  DriveCost(const ob::SpaceInformationPtr& info, const Stands& stands)
      : ob::OptimizationObjective(info), stands_(stands) {}

  ob::Cost stateCost(const ob::State*) const override { return ob::Cost(0.0); }
  ob::Cost motionCost(const ob::State* a, const ob::State* b) const override {
    const auto* space = si_->getStateSpace()->as<Space>();
    const Space::ReedsSheppPath path = space->reedsShepp(a, b);
    const planner::GroundPathConfig& c = stands_.config();
    const double total_m = kRadiusM * path.length();
    if (total_m <= 0) return ob::Cost(0.0);
    const int pieces = 1 + static_cast<int>(total_m / (5e-4 * c.cell_mm));
    ob::State* at = si_->allocState();
    double sum = 0.0;
    double begin_m = 0.0;
    int piece = 0;
    for (int k = 0; k < 5 && piece < pieces; ++k) {
      const double length_m = kRadiusM * std::abs(path.length_[k]);
      const double speed = 1e-3 * (path.length_[k] < 0 ? c.reverse_mm_s : c.speed_mm_s);
      const bool curved = path.type_[k] == Space::RS_LEFT || path.type_[k] == Space::RS_RIGHT;
      const double per_m = std::max(1.0 / speed, curved ? 1e3 / (kRadiusM * c.turn_mrad_s) : 0.0);
      const double end_m = begin_m + length_m;
      for (; piece < pieces && (piece + 0.5) * total_m / pieces <= end_m; ++piece) {
        space->interpolate(a, b, (piece + 0.5) / pieces, at);
        const std::uint8_t price = stands_.price(at);
        sum += total_m / pieces * per_m * (1.0 + std::min(price, planner::kMostPrice) / 16.0);
      }
      begin_m = end_m;
    }
    si_->freeState(at);
    return ob::Cost(sum);
  }
  ob::Cost motionCostHeuristic(const ob::State* a, const ob::State* b) const override {
    const auto* s = a->as<Space::StateType>();
    const auto* t = b->as<Space::StateType>();
    return ob::Cost(std::hypot(s->getX() - t->getX(), s->getY() - t->getY()) /
                    (1e-3 * stands_.config().speed_mm_s));
  }

 private:
  const Stands& stands_;
};

}  // namespace

std::string ompl_drives_missing() { return {}; }

std::string ompl_drives_settings() {
  return "OMPL: Reeds and Shepp's curves of 0.34 m, which is the lattice's tightest, motions checked each "
         "half cell, "
         "the same prices and footprints "
         "(at the nearest cell and heading), the same speeds; the goal in each of 16 headings; RRT* as it "
         "comes, BIT* "
         "as it comes.";
}

void seed_ompl_drives(std::uint32_t seed) {
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  ompl::RNG::setSeed(seed);
}

std::vector<CourseStep> run_ompl(OmplPlanner which, planner::test::OwnedGround& ground,
                                 const planner::GroundPose& start, const planner::GroundPose& goal,
                                 double seconds) {
  const Stands stands(ground);
  const double cell_m = 1e-3 * ground.config.cell_mm;
  auto space = std::make_shared<Space>(kRadiusM);
  ob::RealVectorBounds bounds(2);
  bounds.setLow(0);
  bounds.setHigh(cell_m * ground.config.nx);
  space->setBounds(bounds);
  og::SimpleSetup setup(space);
  const auto& info = setup.getSpaceInformation();
  setup.setStateValidityChecker(
      [&stands](const ob::State* s) { return stands.price(s) <= planner::kMostPrice; });
  const auto place = [&](ob::State* state, const planner::GroundPose& pose, std::int32_t heading) {
    auto* s = state->as<Space::StateType>();
    s->setXY((pose.x + 0.5) * cell_m, (pose.y + 0.5) * cell_m);
    s->setYaw(heading_angle(heading));
    space->enforceBounds(state);
  };
  ob::ScopedState<> at(space);
  place(at.get(), start, start.heading);
  setup.setStartState(at);
  auto goals = std::make_shared<ob::GoalStates>(info);
  for (std::int32_t h = 0; h < planner::kHeadings; ++h) {
    if (goal.heading != planner::kAnyHeading && goal.heading != h) continue;
    place(at.get(), goal, h);
    if (stands.price(at.get()) <= planner::kMostPrice) goals->addState(at);
  }
  setup.setGoal(goals);
  auto objective = std::make_shared<DriveCost>(info, stands);
  const double goal_x = (goal.x + 0.5) * cell_m;
  const double goal_y = (goal.y + 0.5) * cell_m;
  const double speed_m_s = 1e-3 * ground.config.speed_mm_s;
  objective->setCostToGoHeuristic([=](const ob::State* state, const ob::Goal*) {
    const auto* s = state->as<Space::StateType>();
    return ob::Cost(std::hypot(s->getX() - goal_x, s->getY() - goal_y) / speed_m_s);
  });
  setup.setOptimizationObjective(objective);
  space->setLongestValidSegmentFraction(0.5 * cell_m / space->getMaximumExtent());
  if (which == OmplPlanner::rrt_star)
    setup.setPlanner(std::make_shared<og::RRTstar>(info));
  else
    setup.setPlanner(std::make_shared<og::BITstar>(info));
  std::vector<CourseStep> steps;
  const double begin = ground_cpu_ms();
  setup.setup();
  double best = INFINITY;
  const auto look = [&] {
    if (!setup.getProblemDefinition()->hasExactSolution()) return;
    const double cost = which == OmplPlanner::rrt_star
                            ? setup.getPlanner()->as<og::RRTstar>()->bestCost().value()
                            : setup.getPlanner()->as<og::BITstar>()->bestCost().value();
    if (!(cost < best)) return;
    best = cost;
    steps.push_back({ground_cpu_ms() - begin, cost, 0});
  };
  // In pieces of 20 ms: the planner goes on where it was.
  for (double until = begin + 20.0; until < begin + 1e3 * seconds; until = ground_cpu_ms() + 20.0) {
    setup.getPlanner()->solve(ob::PlannerTerminationCondition([until] { return ground_cpu_ms() >= until; }));
    look();
  }
  return steps;
}

#else

std::string ompl_drives_missing() { return "OMPL is missing. Cure: apt-get install libompl-dev"; }
std::string ompl_drives_settings() { return {}; }
void seed_ompl_drives(std::uint32_t) {}
std::vector<CourseStep> run_ompl(OmplPlanner, planner::test::OwnedGround&, const planner::GroundPose&,
                                 const planner::GroundPose&, double) {
  return {};
}

#endif

}  // namespace sortie::bench
