// SPDX-License-Identifier: BSD-3-Clause
// What `sortie bench` can do beside sweeping the keys of a profile.
#pragma once

#include "firmware_like/commands/commands.hpp"

namespace sortie::firmware {

/// --passes of a benchmark that has a program of its own.
void add_passes(Command& command, unsigned& passes);
/// `bench LOG... --sweep`: the options of `bench` itself.
void add_bench_sweep(Command& bench, CommandContext& context);
/// `bench all`: every part below, one after another.
void add_bench_all(Command& bench, CommandContext& context);
/// `bench rt`: the real-time ground beside its peers.
void add_bench_rt(Command& bench, CommandContext& context);
/// `bench plant`: the tracked plant beside its peer.
void add_bench_plant(Command& bench, CommandContext& context);
/// `bench mapping`: the local map beside its peer.
void add_bench_mapping(Command& bench, CommandContext& context);
/// `bench rays`: the ray scheduler beside the published planners.
void add_bench_rays(Command& bench, CommandContext& context);
/// `bench uav`: the multirotor beside its peers.
void add_bench_uav(Command& bench, CommandContext& context);
/// `bench odometry`: attitude and odometry, error against run time.
void add_bench_odometry(Command& bench, CommandContext& context);
/// `bench knobs`: every knob alone, error against run time.
void add_bench_knobs(Command& bench, CommandContext& context);
/// `bench stability`: stiff and extreme cases beside the naive method.
void add_bench_stability(Command& bench, CommandContext& context);
/// `bench campaign`: hostile random sequences for every module.
void add_bench_campaign(Command& bench, CommandContext& context);
/// `bench wcet`: instructions of every job.
void add_bench_wcet(Command& bench, CommandContext& context);

}  // namespace sortie::firmware
