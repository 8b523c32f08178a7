// SPDX-License-Identifier: BSD-3-Clause
// The table of modules under the campaign.
#include <iterator>

#include "tests/bench/campaign/campaign.hpp"
#include "tests/bench/campaign/trials.hpp"

namespace sortie::bench {

namespace {

constexpr std::int64_t kMs = 1'000'000;

constexpr CampaignModule kModules[] = {
    {"rt", "math", "arguments of all sizes, rotations and their inverses",
     "ranges; what undoes what; length 1", 4, 40, kMs, 100, run_math_trial},
    {"rt", "queues", "elements in and out, singly and in blocks, indices about to wrap",
     "the same as a twin; order; lost elements", 6, 200, kMs, 100, run_queue_trial},
    {"rt", "stamps", "stamps of all kinds, counts near the top, percentiles",
     "no stamp back or too far ahead; no new time line before its time; no wrap", 3, 200, 5 * kMs, 100,
     run_stamp_trial},
    {"estimators", "attitude", "inertial samples, speeds, headings; in double and in float",
     "length 1; bias within its limit; variances from 0 up; counters add up", 5, 150, 5 * kMs, 100,
     run_attitude_trial},
    {"estimators", "odometry", "attitudes, forces, travel; with and without obstacles and learning",
     "length 1; the path grows; refused samples move nothing; counters add up", 4, 150, 10 * kMs, 100,
     run_odometry_trial},
    {"estimators", "flight", "inertial samples and fixes, late and early",
     "length 1; deviations from 0 up; counters add up", 4, 150, 5 * kMs, 50, run_uav_state_trial},
    {"mapping", "grid", "scans into pools that are too small, moves of the map; with normals and segments",
     "voxels and blocks within memory; points counted once; backlog", 32, 30, 100 * kMs, 25, run_grid_trial},
    {"planner", "rays", "rays into the occupancy, moves of its window, plans in slices",
     "rays counted once; plans complete, no ray twice, never worse with more units", 8, 60, 100 * kMs, 15,
     run_ray_trial},
    {"planner", "path", "voxels blocked and freed, ways asked for, work in slices, tables too small",
     "no way that the exact check refuses; units within the slice", 4, 60, 100 * kMs, 25, run_path_trial},
    {"planner", "drive", "wishes and waypoints, poses anywhere",
     "speed, turn rate, belts, acceleration and jerk within their limits", 4, 200, 10 * kMs, 100,
     run_drive_trial},
    {"planner", "control", "states, goals and references of the multirotor",
     "rotors within their range; refused states counted", 64, 100, 10 * kMs, 50, run_flight_trial},
    {"planner", "riccati", "systems of two states, stiff, half reachable, or none at all",
     "what is handed out is stable and solves the equation", 3, 12, kMs, 50, run_riccati_trial},
    {"hil", "tracked", "commands and steps, places in the air and in the ground, friction 0 to 10",
     "length 1; refused steps move nothing; above the ground", 32, 100, 2 * kMs, 40, run_tracked_trial},
    {"hil", "multirotor", "commands and steps, wind, lost rotors, an empty battery",
     "rotors within their range; above the ground; refused steps take no time", 64, 100, 2 * kMs, 50,
     run_multirotor_trial},
    {"drivers", "wire", "messages whole, damaged, cut and with another's head",
     "one taker at most, and the same bytes again; whole ones are taken", 20, 60, kMs, 100, run_wire_trial},
    {"drivers", "can", "frames of sensors and of nobody, lost halves, wild counters",
     "samples in order; frames counted once", 4, 150, 5 * kMs, 100, run_can_trial},
    {"firmware_like", "runtime",
     "logs of hostile samples and scans, replayed by the scene of the hall with small pools",
     "samples and points counted once; pools within their size", 6, 120, 5 * kMs, 1, run_runtime_trial},
};

}  // namespace

std::span<const CampaignModule> campaign_modules() { return kModules; }

const CampaignModule* find_campaign_module(const std::string& name) {
  for (const CampaignModule& module : kModules) {
    if (name == module.name) return &module;
  }
  return nullptr;
}

}  // namespace sortie::bench
