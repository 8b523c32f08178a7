// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/processors.hpp"

#include <sched.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

namespace sortie::rt::posix {

namespace {

constexpr const char* kRoot = "/sys/fs/cgroup";

std::string first_line(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

// The smallest quota from the control group at `path` below `root` up to the root; 0: none.
double least_quota(const std::string& root, std::string path, bool is_first_version) {
  double least = 0;
  while (true) {
    const std::string folder = root + path;
    const std::string text = is_first_version ? first_line(folder + "/cpu.cfs_quota_us") + " " +
                                                    first_line(folder + "/cpu.cfs_period_us")
                                              : first_line(folder + "/cpu.max");
    const double quota = processors_of_quota(text);
    if (quota > 0 && (least == 0 || quota < least)) least = quota;
    if (path.empty()) return least;
    path.resize(path.rfind('/') == std::string::npos ? 0 : path.rfind('/'));
  }
}

// Of this process; 0: none.
double quota_here() {
  double least = 0;
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool is_second_version = controllers == ",,";
    if (!is_second_version && controllers.find(",cpu,") == std::string::npos) continue;
    std::string path = line.substr(second + 1);
    if (path == "/") path.clear();
    const double quota = is_second_version ? least_quota(kRoot, path, false)
                                           : least_quota(std::string(kRoot) + "/cpu", path, true);
    if (quota > 0 && (least == 0 || quota < least)) least = quota;
  }
  return least;
}

}  // namespace

bool Processors::has(int core) const { return std::binary_search(cores.begin(), cores.end(), core); }

double processors_of_quota(std::string_view cpu_max) noexcept {
  long long quota = 0;
  long long period = 0;
  char text[64]{};
  cpu_max.copy(text, sizeof(text) - 1);
  // "max 100000" and "-1 100000" say that there is none.
  if (std::sscanf(text, "%lld %lld", &quota, &period) != 2 || quota <= 0 || period <= 0) return 0;
  return static_cast<double>(quota) / static_cast<double>(period);
}

Processors usable_processors(bool quota_binds) {
  Processors processors;
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) {
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (CPU_ISSET(static_cast<unsigned>(core), &set)) processors.cores.push_back(core);
    }
  }
  if (!processors.cores.empty()) processors.count = static_cast<double>(processors.cores.size());
  const double quota = quota_binds ? quota_here() : 0;
  if (quota > 0) processors.count = std::min(processors.count, quota);
  return processors;
}

}  // namespace sortie::rt::posix
