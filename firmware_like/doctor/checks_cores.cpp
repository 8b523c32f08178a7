// SPDX-License-Identifier: BSD-3-Clause
// What differs from core to core: its frequency, its isolation, its interrupts, its sibling, its heat.
#include <algorithm>
#include <map>

#include "firmware_like/doctor/checks.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {
namespace {

const std::string kCpu = "/sys/devices/system/cpu/";

std::string cpu_folder(int core) { return kCpu + "cpu" + std::to_string(core) + "/"; }

/// The cores that a question is about.
std::vector<int> cores_of(const BoardView& board) {
  return board.core >= 0 ? std::vector<int>{board.core} : board.cores;
}

bool holds(const std::vector<int>& cores, int core) {
  return std::find(cores.begin(), cores.end(), core) != cores.end();
}

}  // namespace

Finding check_governor(const BoardView& board) {
  Finding finding{
      "governor", "", Health::unknown,
      "a core that changes its frequency runs the same job at different speeds and stops while it switches"};
  std::map<std::string, std::vector<int>> by_name;
  for (const int core : cores_of(board)) {
    if (const auto name = board.files.read(cpu_folder(core) + "cpufreq/scaling_governor"))
      by_name[*name].push_back(core);
  }
  if (by_name.empty())
    return with(finding, "no cpufreq: firmware or host set the frequency", Health::unknown);
  for (const auto& [name, cores] : by_name) {
    finding.value += (finding.value.empty() ? "" : "; ") + name + " on core " + describe_cores(cores);
  }
  finding.verdict = by_name.size() == 1 && by_name.count("performance") == 1 ? Health::good : Health::warn;
  if (finding.verdict != Health::good)
    finding.cure = "echo performance | sudo tee " + kCpu + "cpu*/cpufreq/scaling_governor";
  return finding;
}

Finding check_isolated_cores(const BoardView& board) {
  Finding finding{"isolated_cores", "", Health::warn,
                  "on a core that ordinary programs share, their time in the kernel delays every release"};
  std::vector<int> isolated = parse_core_list(board.files.read(kCpu + "isolated").value_or(""));
  for (const int core :
       parse_core_list(board.files.read("/sys/fs/cgroup/cpuset.cpus.isolated").value_or(""))) {
    if (!holds(isolated, core)) isolated.push_back(core);
  }
  std::sort(isolated.begin(), isolated.end());
  finding.value = describe_cores(isolated) + " of " + describe_cores(board.cores);
  if (board.core >= 0) finding.value += "; core " + std::to_string(board.core) + " asked";
  if (board.core >= 0 ? holds(isolated, board.core) : !isolated.empty()) {
    finding.verdict = Health::good;
    return finding;
  }
  const std::string target = std::to_string(board.target());
  if (board.cores.size() < 2) {
    finding.value += "; a single core cannot be isolated";
    finding.cure = "nice -n 19 COMMAND  # for everything that is not Sortie";
  } else {
    finding.cure = "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&isolcpus=managed_irq,domain," + target +
                   " nohz_full=" + target + " rcu_nocbs=" + target +
                   " /' /etc/default/grub && sudo update-grub && sudo reboot";
  }
  return finding;
}

Finding check_interrupts(const BoardView& board) {
  Finding finding{"interrupts", "", Health::unknown,
                  "a device's interrupt takes microseconds from whatever job its core runs"};
  constexpr double kFew = 100.0;  // a second: below it the loss is under 0.1 %
  const CoreCounters& counters = board.recent();
  if (counters.time_s <= 0) return not_known(finding);
  double best = -1;
  std::string top;
  for (const int core : cores_of(board)) {
    const auto found = counters.cores.find(core);
    if (found == counters.cores.end()) continue;
    std::uint64_t sum = 0;
    std::uint64_t most = 0;
    std::string name;
    for (const auto& [device, count] : found->second.interrupts) {
      sum += count;
      if (count > most) {
        most = count;
        name = device;
      }
    }
    const double rate = static_cast<double>(sum) / counters.time_s;
    if (best < 0 || rate < best) best = rate;
    finding.value += (finding.value.empty() ? "core " : "; core ") + std::to_string(core) + ": " +
                     format_short(rate) + "/s of devices" + (name.empty() ? "" : " (most: " + name + ")") +
                     ", " + format_short(static_cast<double>(found->second.timer) / counters.time_s) +
                     "/s of its timer";
  }
  if (best < 0) return not_known(finding);
  finding.value += board.window.time_s > 0 ? "" : "; mean since boot";
  finding.verdict = best <= kFew ? Health::good : Health::warn;
  if (finding.verdict != Health::good) {
    std::vector<int> others;
    for (const int core : board.cores) {
      if (core != board.target()) others.push_back(core);
    }
    finding.cure = others.empty()
                       ? "cat /proc/interrupts  # which device asks so often?"
                       : "sudo systemctl stop irqbalance; for f in /proc/irq/*/smp_affinity_list; do echo " +
                             describe_cores(others) + " | sudo tee $f; done";
  }
  return finding;
}

Finding check_smt_sibling(const BoardView& board) {
  Finding finding{
      "smt_sibling", "", Health::good,
      "two hardware threads share one core's units: what runs on the other one halves the speed at will"};
  const CoreCounters& counters = board.recent();
  double busiest = 0;
  std::string siblings;
  for (const int core : cores_of(board)) {
    for (const int other :
         parse_core_list(board.files.read(cpu_folder(core) + "topology/thread_siblings_list").value_or(""))) {
      const auto found = counters.cores.find(other);
      if (other == core || found == counters.cores.end() || found->second.total == 0) continue;
      const double busy = static_cast<double>(found->second.busy) / static_cast<double>(found->second.total);
      siblings += (siblings.empty() ? "" : "; ") + std::to_string(other) + " beside " + std::to_string(core) +
                  ": " + format_fixed(100 * busy, 0) + " % busy";
      busiest = std::max(busiest, busy);
    }
  }
  finding.value = siblings.empty() ? "one hardware thread a core" : siblings;
  if (busiest > 0.05) {
    finding.verdict = Health::warn;
    finding.cure = "echo off | sudo tee " + kCpu + "smt/control";
  }
  return finding;
}

Finding check_heat(const BoardView& board) {
  Finding finding{"heat", "", Health::unknown,
                  "a core that is too hot is slowed by the hardware, in the middle of a job"};
  std::uint64_t since_boot = 0;
  std::uint64_t now = 0;
  bool counted = false;
  for (const int core : cores_of(board)) {
    counted = counted || board.files.exists(cpu_folder(core) + "thermal_throttle/core_throttle_count");
    if (const auto found = board.since_boot.cores.find(core); found != board.since_boot.cores.end())
      since_boot += found->second.throttled;
    if (const auto found = board.window.cores.find(core);
        board.window.time_s > 0 && found != board.window.cores.end())
      now += found->second.throttled;
  }
  // Raspberry Pi: bits 0 to 3 now, 16 to 19 since boot.
  const auto pi = board.files.read("/sys/devices/platform/soc/soc:firmware/get_throttled");
  if (pi) {
    const unsigned long bits = std::strtoul(pi->c_str(), nullptr, 16);
    counted = true;
    now += (bits & 0xfu) != 0 ? 1 : 0;
    since_boot += (bits & 0xf0000u) != 0 ? 1 : 0;
  }
  std::int64_t hottest = 0;
  for (const std::string& zone : board.files.names("/sys/class/thermal")) {
    if (zone.rfind("thermal_zone", 0) != 0) continue;
    hottest = std::max(hottest, board.files.number("/sys/class/thermal/" + zone + "/temp").value_or(0));
  }
  if (hottest > 0) finding.value = format_short(static_cast<double>(hottest) / 1000) + " degrees C; ";
  if (!counted) {
    finding.value += "throttling is not counted here";
    if (hottest > 0) finding.verdict = hottest < 80'000 ? Health::good : Health::warn;
  } else {
    finding.value += since_boot + now == 0 ? "never throttled"
                                           : "throttled " + std::to_string(since_boot) + " times since boot";
    finding.verdict = now > 0 ? Health::bad : since_boot > 0 ? Health::warn : Health::good;
    if (now > 0) finding.value += ", now too";
  }
  if (finding.verdict != Health::good && finding.verdict != Health::unknown)
    finding.cure = "sudo cpupower frequency-set -u 80%  # or a heat sink, a fan, a stronger supply";
  return finding;
}

}  // namespace sortie::firmware
