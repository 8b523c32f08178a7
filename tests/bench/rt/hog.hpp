// SPDX-License-Identifier: BSD-3-Clause
// Ordinary busy processes beside a measurement: arithmetic, memory traffic and system calls in turn.
#pragma once

#include <sys/types.h>

#include <vector>

#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

/// Runs `count` busy processes while it lives.
class Hogs {
 public:
  Hogs(const Settings& settings, int count);
  ~Hogs();
  Hogs(const Hogs&) = delete;
  Hogs& operator=(const Hogs&) = delete;

 private:
  std::vector<pid_t> processes_;
};

}  // namespace sortie::bench
