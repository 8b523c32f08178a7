// SPDX-License-Identifier: BSD-3-Clause
// How the kernel was built and set: preemption, its own shares of the processor, its tick, its clock, and who
// stands below it.
#include <algorithm>
#include <array>

#include "firmware_like/doctor/checks.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {
namespace {

bool holds(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// The word in brackets: "none voluntary (full)", "always [madvise] never".
std::string chosen_word(const std::string& text, char open, char close) {
  const std::size_t from = text.find(open);
  const std::size_t to = text.find(close, from == std::string::npos ? 0 : from);
  return from == std::string::npos || to == std::string::npos ? "" : text.substr(from + 1, to - from - 1);
}

std::string percent(double share) { return format_short(100 * share) + " %"; }

}  // namespace

Finding check_preempt_rt(const BoardView& board) {
  Finding finding{"preempt_rt", "", Health::warn,
                  "without PREEMPT_RT a system call of any program may hold its core for milliseconds"};
  const std::string version = board.files.read("/proc/version").value_or("");
  if (board.files.number("/sys/kernel/realtime").value_or(0) == 1 || holds(version, "PREEMPT_RT"))
    return with(finding, "PREEMPT_RT", Health::good);
  if (version.empty()) return not_known(finding);
  const std::string mode =
      chosen_word(board.files.read("/sys/kernel/debug/sched/preempt").value_or(""), '(', ')');
  finding.value = holds(version, "PREEMPT_DYNAMIC") ? "PREEMPT_DYNAMIC"
                  : holds(version, "PREEMPT")       ? "PREEMPT"
                                                    : "no preemption of the kernel";
  if (!mode.empty()) finding.value += ", set to " + mode;
  finding.cure = "sudo apt install linux-image-rt-" +
                 std::string(holds(version, "aarch64") ? "arm64" : "$(dpkg --print-architecture)");
  return finding;
}

Finding check_rt_throttling(const BoardView& board) {
  Finding finding{"rt_throttling", "", Health::unknown,
                  "the kernel stops all real-time threads of a core that has used up its share"};
  const std::string folder = "/proc/sys/kernel/sched_rt_";
  const auto runtime = board.files.number(folder + "runtime_us");
  const auto period = board.files.number(folder + "period_us");
  if (!runtime || !period || *period <= 0) return not_known(finding);
  if (*runtime < 0) return with(finding, "off", Health::good);
  const double share = static_cast<double>(*runtime) / static_cast<double>(*period);
  finding.value =
      std::to_string(*runtime) + " us of " + std::to_string(*period) + " us (" + percent(share) + ")";
  finding.verdict = share < 0.9 ? Health::bad : Health::warn;
  if (board.kernel_at_least(6, 12))  // the limit is now that of SCHED_DEADLINE; fair_server took its place
    return with(finding, finding.value + ", not applied to SCHED_FIFO since Linux 6.12", Health::good);
  finding.cure = "sudo sysctl -w kernel.sched_rt_runtime_us=-1";
  return finding;
}

Finding check_fair_server(const BoardView& board) {
  Finding finding{"fair_server", "", Health::good,
                  "when ordinary tasks starve on a full core, the kernel takes it from real-time threads in "
                  "blocks of 50 ms"};
  if (board.kernel_major == 0) return not_known(finding);
  if (!board.kernel_at_least(6, 12)) return with(finding, "none before Linux 6.12", Health::good);
  const std::string folder = "/sys/kernel/debug/sched/fair_server/";
  std::int64_t most = -1;
  for (const int core : board.cores) {
    if (board.core >= 0 && core != board.core) continue;
    most =
        std::max(most, board.files.number(folder + "cpu" + std::to_string(core) + "/runtime").value_or(-1));
  }
  if (most == 0) return with(finding, "off", Health::good);
  finding.verdict = Health::warn;
  finding.value = most > 0 ? format_short(static_cast<double>(most) * 1e-6) + " ms a second"
                           : "50 ms a second by default (its setting needs root and debugfs to be read)";
  finding.value += "; acts only on a core that is full, and Sortie's ladder stays below 90 %";
  finding.cure = "echo 0 | sudo tee " + folder + "cpu" +
                 (board.core >= 0 ? std::to_string(board.core) : std::string("*")) + "/runtime";
  return finding;
}

Finding check_timer_tick(const BoardView& board) {
  Finding finding{"timer_tick", "", Health::warn,
                  "the kernel's tick interrupts a running job for some microseconds"};
  const std::vector<int> tickless =
      parse_core_list(board.files.read("/sys/devices/system/cpu/nohz_full").value_or(""));
  finding.value =
      board.tick_ns > 0 ? format_short(1e9 / static_cast<double>(board.tick_ns)) + " Hz" : "rate not known";
  finding.value += tickless.empty() ? ", no core without" : ", none on core " + describe_cores(tickless);
  const std::string target = std::to_string(board.target());
  if (board.timer_resolution_ns > 1000) {
    finding.value += "; timers only as fine as " +
                     format_short(static_cast<double>(board.timer_resolution_ns) * 1e-3) + " us";
    finding.why = "without high resolution timers a release waits for the next tick of the kernel";
    finding.verdict = Health::bad;
    finding.cure = "zgrep HIGH_RES_TIMERS /proc/config.gz; cat /proc/cmdline  # highres=off? then remove it";
    return finding;
  }
  if (board.core >= 0 ? std::find(tickless.begin(), tickless.end(), board.core) != tickless.end()
                      : !tickless.empty()) {
    finding.verdict = Health::good;
    return finding;
  }
  finding.cure = "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&nohz_full=" + target + " rcu_nocbs=" + target +
                 " /' /etc/default/grub && sudo update-grub && sudo reboot";
  return finding;
}

Finding check_clock_source(const BoardView& board) {
  Finding finding{
      "clock_source", "", Health::warn,
      "each job reads the clock several times: 20 ns from a counter, 1 us and more from a device"};
  const std::string folder = "/sys/devices/system/clocksource/clocksource0/";
  const auto source = board.files.read(folder + "current_clocksource");
  if (!source) return not_known(finding);
  finding.value = *source;
  constexpr std::array<const char*, 6> kFast{"tsc",      "arch_sys_counter", "riscv_clocksource",
                                             "timebase", "kvm-clock",        "hyperv_clocksource_tsc_page"};
  constexpr std::array<const char*, 5> kSlow{"hpet", "acpi_pm", "jiffies", "pit", "refined-jiffies"};
  if (std::find(kFast.begin(), kFast.end(), *source) != kFast.end())
    return with(finding, *source, Health::good);
  if (std::find(kSlow.begin(), kSlow.end(), *source) != kSlow.end()) finding.verdict = Health::bad;
  const bool has_tsc =
      holds(" " + board.files.read(folder + "available_clocksource").value_or("") + " ", " tsc ");
  finding.cure = has_tsc ? "echo tsc | sudo tee " + folder + "current_clocksource"
                         : "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&tsc=reliable /' /etc/default/grub && sudo "
                           "update-grub && sudo reboot";
  return finding;
}

Finding check_hypervisor(const BoardView& board) {
  Finding finding{"hypervisor", "none", Health::good,
                  "a host may stop the whole machine for milliseconds, and nothing inside can prevent it"};
  const bool marked = holds(board.files.read("/proc/cpuinfo").value_or(""), " hypervisor") ||
                      board.files.exists("/sys/hypervisor/type") ||
                      board.files.exists("/proc/device-tree/hypervisor");
  std::uint64_t stolen = 0;
  std::uint64_t total = 0;
  for (const auto& [number, core] : board.recent().cores) {
    stolen += core.stolen;
    total += core.total;
  }
  if (!marked && stolen == 0) return finding;
  const double share = total > 0 ? static_cast<double>(stolen) / static_cast<double>(total) : 0;
  finding.value =
      "present; " + percent(share) + " of the time stolen" + (board.window.time_s > 0 ? "" : " since boot");
  finding.verdict = share > 0.001 ? Health::bad : Health::warn;
  finding.cure = "virsh vcpupin DOMAIN " + std::to_string(std::max(board.target(), 0)) +
                 " CORE  # on the host, a core for it alone; or run on the board itself";
  return finding;
}

}  // namespace sortie::firmware
