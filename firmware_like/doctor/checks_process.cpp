// SPDX-License-Identifier: BSD-3-Clause
// What this process may do, and what may happen to its memory.
#include <algorithm>
#include <cstdlib>

#include "firmware_like/doctor/checks.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {
namespace {

constexpr unsigned kCapIpcLock = 14;
constexpr unsigned kCapSysNice = 23;
const char* const kGrant = "sudo setcap cap_sys_nice,cap_ipc_lock=ep $(command -v sortie)";

bool has_capability(const BoardView& board, unsigned bit) {
  for (const std::string& line : split_lines(board.files.read("/proc/self/status").value_or(""))) {
    if (line.rfind("CapEff:", 0) != 0) continue;
    return ((std::strtoull(line.c_str() + 7, nullptr, 16) >> bit) & 1u) != 0;
  }
  return false;
}

/// Soft limit by the name that /proc/self/limits gives it: -1 unlimited, nothing when not known.
std::optional<std::int64_t> limit_of(const BoardView& board, const std::string& name) {
  for (const std::string& line : split_lines(board.files.read("/proc/self/limits").value_or(""))) {
    if (line.rfind(name, 0) != 0) continue;
    const std::vector<std::string> words = split_words(line.substr(name.size()));
    if (words.empty()) return std::nullopt;
    return words[0] == "unlimited" ? std::optional<std::int64_t>(-1) : to_number(words[0]);
  }
  return std::nullopt;
}

/// Kernels with real-time group scheduling give a control group no real-time share unless it is set.
bool group_without_share(const BoardView& board) {
  for (const std::string& line : split_lines(board.files.read("/proc/self/cgroup").value_or(""))) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    if (controllers.find(",cpu,") == std::string::npos) continue;
    for (const char* mount : {"/sys/fs/cgroup/cpu", "/sys/fs/cgroup/cpu,cpuacct"}) {
      if (board.files.number(mount + line.substr(second + 1) + "/cpu.rt_runtime_us") == 0) return true;
    }
  }
  return false;
}

}  // namespace

Finding check_realtime_priority(const BoardView& board) {
  Finding finding{"realtime_priority", "", Health::bad,
                  "without SCHED_FIFO every program may run before the robot's tasks"};
  constexpr std::int64_t kWanted = 80;
  const auto limit = limit_of(board, "Max realtime priority");
  const bool capable = has_capability(board, kCapSysNice);
  if (!limit && !capable && !board.fifo_granted) return not_known(finding);
  finding.value = capable ? "CAP_SYS_NICE" : "rtprio " + std::to_string(limit.value_or(0));
  const bool by_rule = capable || limit.value_or(0) < 0 || limit.value_or(0) >= kWanted;
  const bool granted = board.fifo_granted.value_or(by_rule && !group_without_share(board));
  if (granted)
    return with(finding, finding.value + (board.fifo_granted ? ", granted when asked" : ""), Health::good);
  if (by_rule) {
    finding.value += group_without_share(board) ? ", but the control group has no real-time share"
                                                : ", but refused when asked";
    finding.cure =
        "echo 950000 | sudo tee /sys/fs/cgroup/cpu/$(grep -w cpu /proc/self/cgroup | cut -d: "
        "-f3)/cpu.rt_runtime_us";
    return finding;
  }
  if (limit.value_or(0) > 0) finding.verdict = Health::warn;
  finding.cure = kGrant;
  return finding;
}

Finding check_memory_lock(const BoardView& board) {
  Finding finding{"memory_lock", "", Health::bad,
                  "a page that is not locked may be missing when a job touches it: milliseconds from a disk"};
  constexpr std::int64_t kPlenty = std::int64_t{256} << 20;
  const auto limit = limit_of(board, "Max locked memory");
  if (has_capability(board, kCapIpcLock)) return with(finding, "CAP_IPC_LOCK", Health::good);
  if (!limit) return not_known(finding);
  if (*limit < 0) return with(finding, "unlimited", Health::good);
  finding.cure = kGrant;
  return with(finding, "at most " + group_digits(static_cast<std::uint64_t>(*limit) / 1024) + " KiB",
              *limit >= kPlenty ? Health::warn : Health::bad);
}

Finding check_swap(const BoardView& board) {
  Finding finding{
      "swap", "none", Health::good,
      "what is not locked (other programs, files of the log) goes to the disk and makes everybody wait"};
  const auto text = board.files.read("/proc/swaps");
  if (!text) return not_known(finding);
  std::int64_t size = 0;
  std::int64_t used = 0;
  for (const std::string& line : split_lines(*text)) {
    const std::vector<std::string> words = split_words(line);
    if (words.size() < 5 || words[0] == "Filename") continue;
    size += to_number(words[2]).value_or(0);
    used += to_number(words[3]).value_or(0);
  }
  if (size == 0) return finding;
  finding.value = group_digits(static_cast<std::uint64_t>(size / 1024)) + " MiB, " +
                  group_digits(static_cast<std::uint64_t>(used / 1024)) + " MiB used";
  finding.verdict = Health::warn;
  finding.cure = "sudo swapoff -a";
  return finding;
}

Finding check_huge_pages(const BoardView& board) {
  Finding finding{"huge_pages", "", Health::unknown,
                  "the kernel moves memory about to make huge pages, and a process waits for it"};
  const std::string path = "/sys/kernel/mm/transparent_hugepage/enabled";
  const std::string text = board.files.read(path).value_or("");
  const std::size_t from = text.find("[");
  const std::size_t to = text.find("]");
  if (from == std::string::npos || to == std::string::npos || to < from) {
    finding.value = text.empty() ? "the kernel has none" : text;
    finding.verdict = text.empty() ? Health::good : Health::unknown;
    return finding;
  }
  finding.value = text.substr(from + 1, to - from - 1);
  finding.verdict = finding.value == "always" ? Health::warn : Health::good;
  if (finding.verdict != Health::good) finding.cure = "echo madvise | sudo tee " + path;
  return finding;
}

Finding check_cpu_dma_latency(const BoardView& board) {
  Finding finding{"cpu_dma_latency", "", Health::good,
                  "an idle core sleeps deeply and wakes tens to hundreds of microseconds late"};
  const std::string device = "/dev/cpu_dma_latency";
  std::int64_t deepest = 0;
  const std::string folder =
      "/sys/devices/system/cpu/cpu" + std::to_string(std::max(board.target(), 0)) + "/cpuidle/";
  for (const std::string& state : board.files.names(folder)) {
    if (board.files.number(folder + state + "/disable").value_or(0) == 0)
      deepest = std::max(deepest, board.files.number(folder + state + "/latency").value_or(0));
  }
  const std::string depth = deepest > 0 ? "the deepest idle state wakes in " + std::to_string(deepest) + " us"
                                        : "the kernel knows no deep idle state";
  if (board.files.writable(device)) {
    finding.value = depth + "; runs hold it at 0 us";
  } else if (deepest == 0) {
    finding.value = depth;
  } else {
    finding.value = depth + "; this process may not hold it";
    finding.verdict = Health::warn;
    finding.cure = "sudo chmod 666 " + device;
  }
  return finding;
}

}  // namespace sortie::firmware
