// SPDX-License-Identifier: BSD-3-Clause
// A made-up board for the doctor: the files that it reads, below a folder of the test's own.
#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "firmware_like/doctor/doctor.hpp"
#include "tests/firmware_like/temp_folder.hpp"

namespace sortie::testing {

/// Where the kernel tells of its cores.
inline const std::string kCpu = "/sys/devices/system/cpu/";

/// A board with four cores on which everything is as it should be; tests spoil one thing at
/// a time.
class Board {
 public:
  Board() {
    set("/proc/version", "Linux version 6.1.0-rt (gcc) #1 SMP PREEMPT_RT Debian aarch64");
    set("/proc/sys/kernel/osrelease", "6.1.0-rt-arm64");
    set("/proc/sys/kernel/sched_rt_runtime_us", "-1");
    set("/proc/sys/kernel/sched_rt_period_us", "1000000");
    set("/proc/self/status", "Name:\tsortie\nCapEff:\t0000000000000000\n");
    limits("unlimited", "99");
    set("/proc/swaps", "Filename\tType\tSize\tUsed\tPriority");
    set("/proc/cpuinfo", "flags : fpu sse2");
    set("/proc/uptime", "1000.00 3000.00");
    set("/proc/stat", stat(0, 0));
    set("/proc/interrupts", interrupts(5, 7));
    set("/sys/devices/system/cpu/online", "0-3");
    set("/sys/devices/system/cpu/isolated", "2-3");
    set("/sys/devices/system/cpu/nohz_full", "2-3");
    set("/sys/devices/system/clocksource/clocksource0/current_clocksource", "arch_sys_counter");
    set("/sys/devices/system/clocksource/clocksource0/available_clocksource", "arch_sys_counter");
    set("/sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never");
    for (int core = 0; core < 4; ++core) {
      const std::string cpu = "/sys/devices/system/cpu/cpu" + std::to_string(core) + "/";
      set(cpu + "cpufreq/scaling_governor", "performance");
      set(cpu + "topology/thread_siblings_list", std::to_string(core));
      set(cpu + "cpuidle/state0/latency", "0");
      set(cpu + "cpuidle/state1/latency", "450");
      set(cpu + "thermal_throttle/core_throttle_count", "0");
    }
    set("/sys/class/thermal/thermal_zone0/temp", "51500");
    set("/dev/cpu_dma_latency", "");
  }
  void set(const std::string& path, const std::string& content) {
    std::filesystem::create_directories(std::filesystem::path(folder_.path() + path).parent_path());
    std::ofstream(folder_.path() + path) << content << "\n";
  }
  void drop(const std::string& path) { std::filesystem::remove_all(folder_.path() + path); }
  void limits(const std::string& memory, const std::string& priority) {
    set("/proc/self/limits",
        "Limit                     Soft Limit           Hard Limit           Units     \n"
        "Max locked memory         " +
            memory +
            "              unlimited            bytes     \n"
            "Max realtime priority     " +
            priority + "                    99                             ");
  }
  static std::string stat(int stolen, int busy_of_core_1) {
    std::string text = "cpu  1 1 1 1 1 1 1 1 0 0\n";
    for (int core = 0; core < 4; ++core) {
      const int busy = core == 1 ? busy_of_core_1 : 10;
      text += "cpu" + std::to_string(core) + " " + std::to_string(busy) + " 0 0 " +
              std::to_string(1000 - busy) + " 0 0 0 " + std::to_string(stolen) + " 0 0\n";
    }
    return text;
  }
  // Device counts of cores 0 and 3; cores 1 and 2 serve `others`.
  static std::string interrupts(int zero, int three, int others = 3) {
    const std::string middle = " " + std::to_string(others) + " " + std::to_string(others) + " ";
    return "           CPU0       CPU1       CPU2       CPU3\n"
           " 11:  9000 9000 9000 9000  GICv3  27 Level     arch_timer\n"
           " 40:  " +
           std::to_string(zero) + middle + std::to_string(three) +
           "  GICv3  80 Level     can0\n"
           "IPI0: 100000 100000 100000 100000  Rescheduling interrupts\n"
           "Err:  0";
  }
  firmware::DoctorReport report(int core = -1) const { return firmware::Doctor(options(core)).report(); }
  firmware::DoctorOptions options(int core = -1) const { return {folder_.path(), core}; }

 private:
  TempFolder folder_;
};

/// The finding of that name; the test fails when there is none.
inline const firmware::Finding& finding(const firmware::DoctorReport& report, const std::string& name) {
  for (const firmware::Finding& one : report.findings) {
    if (one.name == name) return one;
  }
  FAIL("no finding " << name);
  return report.findings.front();
}

}  // namespace sortie::testing
