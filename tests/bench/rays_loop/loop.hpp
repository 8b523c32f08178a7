// SPDX-License-Identifier: BSD-3-Clause
// One closed loop: a policy asks, the simulated device answers, the map learns, and truth judges it.
#pragma once

#include <string>
#include <vector>

#include "mapping/occupancy/occupancy.hpp"
#include "planner/ssl_choice.hpp"
#include "tests/bench/rays_loop/loop_worlds.hpp"

namespace sortie::bench {

/// What is compared.
struct LoopArm {
  std::string name;
  planner::SslChoiceConfig choice;
  std::uint64_t units{2'000'000};  ///< for each command
};

/// Sizes of a loop.
struct LoopSize {
  int frames{30};
  double period_s{0.2};
  std::uint32_t rays{200};
};

/// Map and truth share this window, which stands still.
mapping::OccupancyConfig loop_map_config();

/// What is true of the window's cells, as far as the sensor could have seen it, by the rule of the paper's
/// code: all 19,200 directions from each place of the way, without noise; -1 for a ray that passes, +2 for
/// one that ends, occupied from 2 on. 0: not seen, 1: free, 2: occupied.
std::vector<std::uint8_t> loop_truth(const LoopWorld& world, const LoopSize& size);

/// How a loop went, frame after frame.
struct LoopResult {
  std::vector<double> loss;   ///< weighted log-loss after each frame
  std::vector<double> found;  ///< occupied cells found for each ray fired so far
  int unplanned{};            ///< commands without a plan
};

/// Runs one arm. `seed`: of the sensor's noise and of chance; the same for all arms of a pair.
LoopResult run_loop(const LoopWorld& world, const std::vector<std::uint8_t>& truth, const LoopArm& arm,
                    const LoopSize& size, std::uint64_t seed);

}  // namespace sortie::bench
