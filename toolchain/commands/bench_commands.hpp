// SPDX-License-Identifier: BSD-3-Clause
// What `sortie bench` can do beside sweeping the keys of a profile.
#pragma once

#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

/// `bench LOG... --sweep`: the options of `bench` itself.
void add_bench_sweep(firmware::Command& bench, CommandContext& context);
/// `bench all`: every part below, one after another.
void add_bench_all(firmware::Command& bench, CommandContext& context);
/// `bench rt`, `plant`, `mapping`, `uav`, `stability`, `campaign`, `rays`: those that have programs of their
/// own.
void add_bench_peers(firmware::Command& bench, CommandContext& context);
/// `bench odometry`: attitude and odometry, error against run time.
void add_bench_odometry(firmware::Command& bench, CommandContext& context);
/// `bench wcet`: instructions of every job.
void add_bench_wcet(firmware::Command& bench, CommandContext& context);

}  // namespace sortie::toolchain
