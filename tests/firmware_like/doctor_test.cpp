// SPDX-License-Identifier: BSD-3-Clause
// The doctor on made-up boards: every finding in its good and its bad form, from files that a test writes.
#include "firmware_like/doctor/doctor.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "firmware_like/scene/input_error.hpp"
#include "tests/firmware_like/doctor_board.hpp"

using namespace sortie;
using namespace sortie::firmware;
using sortie::testing::Board;
using sortie::testing::finding;
using sortie::testing::kCpu;
using sortie::testing::TempFolder;

namespace {

// The names of the findings whose verdicts differ.
std::vector<std::string> changed(const DoctorReport& before, const DoctorReport& after) {
  std::vector<std::string> names;
  for (const firmware::Finding& one : after.findings) {
    if (one.verdict != finding(before, one.name).verdict) names.push_back(one.name);
  }
  return names;
}

// True when a finding is of this verdict, and its value and its cure hold these words.
bool says(const firmware::Finding& found, Health verdict, const std::string& value, const std::string& cure) {
  UNSCOPED_INFO(found.name << ": " << to_string(found.verdict) << ": " << found.value << " | " << found.cure);
  return found.verdict == verdict && found.value.find(value) != std::string::npos &&
         found.cure.find(cure) != std::string::npos;
}

}  // namespace

TEST_CASE("a board that is set up well has nothing but good findings") {
  const Board board;
  for (const int core : {-1, 2, 3}) {
    const DoctorReport report = board.report(core);
    for (const firmware::Finding& one : report.findings) {
      INFO(one.name << ": " << one.value);
      CHECK(one.verdict == Health::good);
      CHECK(one.cure.empty());
      CHECK_FALSE(one.value.empty());
      CHECK_FALSE(one.why.empty());
      CHECK(one.why.find('\n') == std::string::npos);
    }
    CHECK(report.findings.size() == 16);
    CHECK(report.verdict() == Health::good);
    CHECK(report.summary() == "16 good");
  }
}

TEST_CASE("each thing that is spoiled is found and cured and nothing else changes") {
  struct Spoiled {
    const char* finding;
    std::string path;
    std::string content;
    Health verdict;
    const char* value;
    const char* cure;
  };
  const std::string clock = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  const Spoiled all[] = {
      {"governor", kCpu + "cpu1/cpufreq/scaling_governor", "schedutil", Health::warn, "schedutil on core 1",
       "echo performance"},
      {"isolated_cores", kCpu + "isolated", "", Health::warn, "none of 0-3", "isolcpus=managed_irq,domain,3"},
      {"rt_throttling", "/proc/sys/kernel/sched_rt_runtime_us", "950000", Health::warn, "95 %",
       "sched_rt_runtime_us=-1"},
      {"rt_throttling", "/proc/sys/kernel/sched_rt_runtime_us", "500000", Health::bad, "50 %",
       "sched_rt_runtime_us=-1"},
      {"preempt_rt", "/proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC aarch64", Health::warn,
       "PREEMPT_DYNAMIC", "linux-image-rt-arm64"},
      {"clock_source", clock, "acpi_pm", Health::bad, "acpi_pm", "tsc=reliable"},
      {"huge_pages", "/sys/kernel/mm/transparent_hugepage/enabled", "[always] madvise never", Health::warn,
       "always", "echo madvise"},
      {"timer_tick", kCpu + "nohz_full", "(null)", Health::warn, "no core without", "nohz_full=3"},
      {"swap", "/proc/swaps", "Filename Type Size Used Priority\n/dev/sda2 partition 2097148 1024 -2",
       Health::warn, "2,047 MiB, 1 MiB used", "swapoff"},
      {"hypervisor", "/proc/cpuinfo", "flags : fpu hypervisor sse2", Health::warn, "0 % of the time stolen",
       "vcpupin DOMAIN 3"},
      {"hypervisor", "/proc/stat", Board::stat(50, 10), Health::bad, "4.76 % of the time stolen", "vcpupin"},
      {"heat", kCpu + "cpu2/thermal_throttle/core_throttle_count", "12", Health::warn, "throttled 12 times",
       "cpupower"},
      {"heat", "/sys/devices/platform/soc/soc:firmware/get_throttled", "0x50005", Health::bad, "now too",
       "cpupower"},
  };
  for (const Spoiled& one : all) {
    Board board;
    const DoctorReport before = board.report();
    board.set(one.path, one.content);
    const DoctorReport after = board.report();
    INFO(one.path << " holds " << one.content);
    CHECK(says(finding(after, one.finding), one.verdict, one.value, one.cure));
    CHECK(changed(before, after) == std::vector<std::string>{one.finding});
  }
}

TEST_CASE("what differs from core to core is judged by the core that is asked about") {
  Board board;
  CHECK(finding(board.report(1), "isolated_cores").verdict == Health::warn);
  CHECK(finding(board.report(3), "isolated_cores").verdict == Health::good);
  CHECK(finding(board.report(0), "timer_tick").verdict == Health::warn);
  board.set(kCpu + "cpu1/cpufreq/scaling_governor", "powersave");
  CHECK(finding(board.report(1), "governor").verdict == Health::warn);
  CHECK(finding(board.report(3), "governor").verdict == Health::good);
  board.set("/sys/fs/cgroup/cpuset.cpus.isolated", "1");
  CHECK(finding(board.report(1), "isolated_cores").verdict == Health::good);
  CHECK_THROWS_AS(board.report(4), InputError);
}

TEST_CASE("rights are read from limits and capabilities") {
  Board board;
  board.limits("8388608", "0");
  DoctorReport report = board.report();
  CHECK(says(finding(report, "memory_lock"), Health::bad, "8,192 KiB", "setcap"));
  CHECK(says(finding(report, "realtime_priority"), Health::bad, "rtprio 0", "setcap"));
  CHECK(report.verdict() == Health::bad);
  CHECK(report.summary() == "bad: realtime_priority, memory_lock; 14 good");
  board.limits("1073741824", "20");
  report = board.report();
  CHECK(finding(report, "memory_lock").verdict == Health::warn);
  CHECK(finding(report, "realtime_priority").verdict == Health::warn);
  board.set("/proc/self/status", "CapEff:\t0000000000804000");  // CAP_SYS_NICE and CAP_IPC_LOCK, no more
  report = board.report();
  CHECK(finding(report, "memory_lock").value == "CAP_IPC_LOCK");
  CHECK(finding(report, "realtime_priority").value == "CAP_SYS_NICE");
  CHECK(report.verdict() == Health::good);
  board.limits("8388608", "0");
  board.set("/proc/self/status", "CapEff:\t0000000000800000");  // CAP_SYS_NICE alone
  report = board.report();
  CHECK(finding(report, "memory_lock").verdict == Health::bad);
  CHECK(finding(report, "realtime_priority").verdict == Health::good);
  // A control group without a share of real time refuses in spite of all rights.
  board.set("/proc/self/cgroup", "2:cpuset:/\n1:cpu,cpuacct:/robot");
  board.set("/sys/fs/cgroup/cpu/robot/cpu.rt_runtime_us", "0");
  CHECK(says(finding(board.report(), "realtime_priority"), Health::bad, "no real-time share",
             "cpu.rt_runtime_us"));
}

TEST_CASE("the fair server follows the kernel's version and its setting") {
  Board board;
  CHECK(finding(board.report(), "fair_server").value == "none before Linux 6.12");
  board.set("/proc/sys/kernel/osrelease", "6.12.1");
  board.set("/proc/sys/kernel/sched_rt_runtime_us", "950000");
  CHECK(says(finding(board.report(2), "fair_server"), Health::warn, "50 ms a second by default",
             "fair_server/cpu2/runtime"));
  CHECK(finding(board.report(), "rt_throttling").verdict == Health::good);  // no longer applied to SCHED_FIFO
  for (const char* core : {"0", "1", "2", "3"})
    board.set("/sys/kernel/debug/sched/fair_server/cpu" + std::string(core) + "/runtime", "0");
  CHECK(finding(board.report(), "fair_server").verdict == Health::good);
  board.set("/sys/kernel/debug/sched/fair_server/cpu3/runtime", "20000000");
  CHECK(says(finding(board.report(3), "fair_server"), Health::warn, "20 ms a second", "fair_server/cpu3"));
  CHECK(finding(board.report(2), "fair_server").verdict == Health::good);
}

TEST_CASE("interrupts are rates of the time between two readings and name the busiest device") {
  Board board;
  const Doctor doctor(board.options(0));
  board.set("/proc/uptime", "1002.00 3000.00");
  board.set("/proc/interrupts", Board::interrupts(3005, 7));
  CHECK(says(finding(doctor.report(), "interrupts"), Health::warn, "core 0: 1500/s of devices (most: can0)",
             "echo 1-3"));
  const Doctor quiet(board.options(3));
  board.set("/proc/uptime", "1004.00 3000.00");
  board.set("/proc/interrupts", Board::interrupts(9000, 9));
  const firmware::Finding found = finding(quiet.report(), "interrupts");
  CHECK(found.verdict == Health::good);
  CHECK(found.value == "core 3: 1/s of devices (most: can0), 0/s of its timer");
  // On x86 the timer is not a device and has a label instead of a number.
  board.set("/proc/interrupts",
            "  CPU0 CPU3\n 9: 10 4 IO-APIC 9-fasteoi acpi\nLOC: 500 400 Local timer interrupts");
  const Doctor ticking(board.options(0));
  board.set("/proc/uptime", "1006.00 3000.00");
  board.set("/proc/interrupts",
            "  CPU0 CPU3\n 9: 30 4 IO-APIC 9-fasteoi acpi\nLOC: 1000 900 Local timer interrupts");
  CHECK(finding(ticking.report(), "interrupts").value ==
        "core 0: 10/s of devices (most: acpi), 250/s of its timer");
  board.set("/proc/uptime", "1004.00 3000.00");
  board.set("/proc/interrupts", Board::interrupts(9000, 9));
  // One reading only: the mean since boot, 9 in 1004 s.
  CHECK(finding(board.report(3), "interrupts").value.find("core 3: 0.009") == 0);
  CHECK(finding(board.report(3), "interrupts").value.find("since boot") != std::string::npos);
}

TEST_CASE("a sibling that computes and heat that throttles now are seen in the window") {
  Board board;
  board.set(kCpu + "cpu2/topology/thread_siblings_list", "1-2");
  board.set(kCpu + "cpu1/topology/thread_siblings_list", "1-2");
  CHECK(finding(board.report(2), "smt_sibling").verdict == Health::good);
  board.set("/proc/stat", Board::stat(0, 900));
  CHECK(says(finding(board.report(2), "smt_sibling"), Health::warn, "1 beside 2: 90 % busy", "smt/control"));
  const Doctor doctor(board.options(2));
  board.set("/proc/uptime", "1010.00 3000.00");
  board.set(kCpu + "cpu2/thermal_throttle/core_throttle_count", "3");
  CHECK(says(finding(doctor.report(), "heat"), Health::bad, "now too", "cpupower"));
}

TEST_CASE("idle states that nobody may hold off are found") {
  Board board;
  board.drop("/dev/cpu_dma_latency");
  CHECK(says(finding(board.report(), "cpu_dma_latency"), Health::warn, "wakes in 450 us", "chmod 666"));
  for (const char* core : {"0", "1", "2", "3"}) board.drop(kCpu + "cpu" + core + "/cpuidle");
  CHECK(finding(board.report(), "cpu_dma_latency").verdict == Health::good);
}

TEST_CASE("a machine that tells nothing is unknown and never bad") {
  const TempFolder empty;
  const DoctorReport report = Doctor({empty.path(), -1}).report();
  CHECK(report.findings.size() == 16);
  for (const firmware::Finding& one : report.findings) {
    INFO(one.name << ": " << one.value);
    CHECK(one.verdict != Health::bad);
    CHECK_FALSE(one.value.empty());
  }
}

TEST_CASE("files full of nonsense do no harm") {
  Board board;
  const std::string junk =
      "CPU-1 99999999999999999999 [ ( 1-99999999 cpu cpu99999999999 : : :\n0: \n1: x y z\n((((";
  for (const char* path :
       {"/proc/version", "/proc/sys/kernel/osrelease", "/proc/sys/kernel/sched_rt_runtime_us",
        "/proc/self/status", "/proc/self/limits", "/proc/self/cgroup", "/proc/swaps", "/proc/cpuinfo",
        "/proc/uptime", "/proc/stat", "/proc/interrupts", "/sys/devices/system/cpu/online",
        "/sys/devices/system/cpu/isolated", "/sys/kernel/mm/transparent_hugepage/enabled",
        "/sys/class/thermal/thermal_zone0/temp"}) {
    INFO(path);
    board.set(path, junk);
    CHECK(board.report().findings.size() == 16);
  }
}

TEST_CASE("the own machine is examined without an error") {
  const Doctor doctor({"/", -1});
  std::this_thread::sleep_for(std::chrono::milliseconds(120));
  const DoctorReport report = doctor.report();
  CHECK(report.findings.size() == 16);
  CHECK_FALSE(report.machine.empty());
}
