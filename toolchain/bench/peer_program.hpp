// SPDX-License-Identifier: BSD-3-Clause
// Benchmarks that link what the product does not are programs of their own: found, run and read here.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json.hpp"

namespace sortie::toolchain {

/// The benchmark's program is not there or failed; commands end with exit code 4.
class BenchRefused : public firmware::PlatformRefused {
 public:
  using firmware::PlatformRefused::PlatformRefused;
};

/// Which program, and what it is told.
struct PeerProgram {
  std::string name;                    ///< such as sortie-bench-rt
  std::string given;                   ///< its path, if it is not where a build or an installation puts it
  std::vector<std::string> arguments;  ///< without the program itself
  int core{-1};                        ///< that it measures on, for the doctor; -1: the last one
  unsigned passes{1};                  ///< so many times, a process each
  bool all_timed{};                    ///< none of its figures is the same at every run
};

/// Runs it (its progress goes to stderr) and returns the object that it printed, with machine, compiler and
/// the doctor's verdict added. What lies where in memory differs from process to process and moves times by
/// more than the rounds of one of them show: with several passes the ranges hold all of them (take_pass()).
/// Throws BenchRefused with the cure.
firmware::Json run_peer_program(const PeerProgram& program);

}  // namespace sortie::toolchain
