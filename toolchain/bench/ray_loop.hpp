// SPDX-License-Identifier: BSD-3-Clause
// The closed loop of the solid-state lidar's policies: a program of its own (sortie-bench-rays-loop) that is
// found, run and shown here.
#pragma once

#include "toolchain/bench/ray_bench.hpp"

namespace sortie::toolchain {

/// Seeds of each scene where nothing else is asked for.
inline constexpr int kLoopSeeds = 12;

/// Runs the benchmark; `seeds` pairs a scene. Throws BenchRefused with the cure.
firmware::Json run_ray_loop(int seeds, const std::string& program);

/// The result as a Markdown page, with `command` as how to get it again.
std::string ray_loop_page(const firmware::Json& result, const std::string& command);

/// The course of the loss, scene by scene.
std::vector<RayPicture> ray_loop_pictures(const firmware::Json& result);

}  // namespace sortie::toolchain
