// SPDX-License-Identifier: BSD-3-Clause
// Release gates: bounds that a result must keep, in a TOML file of a user's own.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/toml_file.hpp"

namespace sortie::toolchain {

/// What a gate may bound. A figure stands in exactly one of the two: what is not known is never a zero.
struct GateFigures {
  std::map<std::string, double> known;
  std::map<std::string, std::string> absent;  ///< not measured by this result: why, and the cure
};

/// All figures of a result by the names of docs/command-line.md. What a clock gave is the live run's
/// (LiveTimes); the times of the machine that ran the command have names that begin with "here.". A new
/// figure is added here, on that page, and in tests/toolchain/gate_names_test.cpp, which plants every name
/// broken.
GateFigures gate_figures(const firmware::Results& results);

/// A gate file. Tables [max] and [min], each of dotted names of the result's JSON:
///   [max]
///   errors.ate_rmse_m = 0.5
///   counters.heap_calls = 0
///   tasks.map.p99_us = 40000
///   pools.voxels.refused = 0
///   groups.control.response_max_us = 800
///   chains.imu_to_pose.measured_age.max_us = 20000
///   all.missed = 0            # of all groups; all.max_us, all.response_max_us, all.refused likewise
/// and [equal] of texts: digest, scene, vehicle.
class Gate {
 public:
  /// Throws ProfileError, before anything is run, if the file cannot be read, holds a bound that is none, or
  /// no bound at all: that gate could not fail.
  explicit Gate(std::string path);

  /// One line for each bound that is broken. Throws ProfileError if it names a figure that the result does
  /// not have, with the cure.
  std::vector<std::string> judge(const firmware::Results& results) const;

 private:
  void hold(const firmware::TomlNode& table, const std::string& prefix, bool is_max,
            const GateFigures& figures, std::vector<std::string>& broken) const;
  std::size_t check_kinds(const firmware::TomlNode& table, const std::string& prefix) const;
  std::string place(const firmware::TomlNode& node) const;

  std::string path_;
  firmware::TomlTree tree_;
};

}  // namespace sortie::toolchain
