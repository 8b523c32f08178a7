// SPDX-License-Identifier: BSD-3-Clause
// The benchmarks that have programs of their own, and their pictures.
#pragma once

#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

PeerFront rt_front();            ///< the real-time ground beside cyclictest and boost
PeerFront plant_front();         ///< the tracked plant beside ODE
PeerFront mapping_front();       ///< the local map beside PCL
PeerFront registration_front();  ///< the registration of scans and clouds beside PCL's
PeerFront uav_front();           ///< the multirotor beside Lee's controller and others
PeerFront stability_front();     ///< stiff and extreme cases beside the naive method
PeerFront campaign_front();      ///< hostile random sequences for every module
PeerFront ray_front();           ///< the ray scheduler beside the published planners; closed loops

/// Marks the cells of the local map's sweep that no other beats: each stream and policy has its front.
void mark_mapping_fronts(firmware::Json& result);

/// Lateness of wake-ups: log count over microseconds, one curve a method, a line at the period.
std::vector<BenchPicture> rt_pictures(const firmware::Json& result);
/// Error over run time, and a side view of each drive over obstacles.
std::vector<BenchPicture> plant_pictures(const firmware::Json& result);
/// Error of segments over run time, a picture a stream.
std::vector<BenchPicture> mapping_pictures(const firmware::Json& result);
/// Worth over run time, and the chosen rays over the entropy of the map.
std::vector<BenchPicture> ray_pictures(const firmware::Json& result);
/// The course of the loss, scene by scene.
std::vector<BenchPicture> ray_loop_pictures(const firmware::Json& result);
/// The page of the closed loops: policies that aim the solid-state lidar.
std::string ray_loop_page(const firmware::Json& result, const std::string& command);
/// Whatever the program drew.
std::vector<BenchPicture> drawn_pictures(const firmware::Json& result);

}  // namespace sortie::toolchain
