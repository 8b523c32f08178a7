// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/doctor/core_counters.hpp"

#include <algorithm>
#include <cstdlib>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {
namespace {

std::uint64_t count_of(const std::string& word) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(to_number(word).value_or(0), 0));
}

bool all_digits(const std::string& word) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
}

/// "CPU0 CPU3", then rows "32: 1080 0 PCI-MSIX virtio0" of devices and "LOC: 1 2 Local timer" of the kernel.
void read_interrupts(const MachineFiles& files, CoreCounters& counters) {
  std::vector<int> columns;
  for (const std::string& line : split_lines(files.read("/proc/interrupts").value_or(""))) {
    const std::vector<std::string> words = split_words(line);
    if (words.empty()) continue;
    if (columns.empty()) {
      for (const std::string& word : words) {
        if (word.rfind("CPU", 0) != 0 || !all_digits(word.substr(3))) return;
        columns.push_back(static_cast<int>(count_of(word.substr(3))));
      }
      continue;
    }
    if (words[0].back() != ':' || words.size() < columns.size() + 1) continue;
    const std::string label = words[0].substr(0, words[0].size() - 1);
    const std::string& last = words.back();
    // On ARM the core's timer is a device like any other, but for its name.
    const bool timer = label == "LOC" || last == "arch_timer" || last.find("timer") != std::string::npos;
    if (!timer && !all_digits(label)) continue;
    const bool named = words.size() > columns.size() + 1;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      CoreCounters::Core& core = counters.cores[columns[i]];
      (timer ? core.timer : core.interrupts[named ? last : "irq " + label]) += count_of(words[i + 1]);
    }
  }
}

/// "cpu3 user nice system idle iowait irq softirq steal ..."
void read_times(const MachineFiles& files, CoreCounters& counters) {
  for (const std::string& line : split_lines(files.read("/proc/stat").value_or(""))) {
    const std::vector<std::string> words = split_words(line);
    if (words.size() < 9 || words[0].rfind("cpu", 0) != 0 || !all_digits(words[0].substr(3))) continue;
    CoreCounters::Core& core = counters.cores[static_cast<int>(count_of(words[0].substr(3)))];
    for (std::size_t i = 1; i <= 8; ++i) {
      core.total += count_of(words[i]);
      if (i != 4 && i != 5 && i != 8) core.busy += count_of(words[i]);
    }
    core.stolen = count_of(words[8]);
  }
}

}  // namespace

CoreCounters read_counters(const MachineFiles& files) {
  CoreCounters counters;
  read_interrupts(files, counters);
  read_times(files, counters);
  for (auto& [number, core] : counters.cores) {
    const std::string folder = "/sys/devices/system/cpu/cpu" + std::to_string(number) + "/thermal_throttle/";
    for (const char* name : {"core_throttle_count", "package_throttle_count"}) {
      const std::int64_t count = files.number(folder + name).value_or(0);
      core.throttled += static_cast<std::uint64_t>(std::max<std::int64_t>(count, 0));
    }
  }
  const std::string uptime = files.read("/proc/uptime").value_or("");
  counters.time_s = std::strtod(uptime.c_str(), nullptr);
  return counters;
}

CoreCounters difference(const CoreCounters& later, const CoreCounters& earlier) {
  const auto minus = [](std::uint64_t a, std::uint64_t b) { return a > b ? a - b : 0; };
  CoreCounters result = later;
  result.time_s = later.time_s - earlier.time_s;
  for (auto& [number, core] : result.cores) {
    const auto before = earlier.cores.find(number);
    if (before == earlier.cores.end()) continue;
    for (auto& [name, count] : core.interrupts) {
      const auto old = before->second.interrupts.find(name);
      if (old != before->second.interrupts.end()) count = minus(count, old->second);
    }
    using Core = CoreCounters::Core;
    for (const auto count : {&Core::timer, &Core::busy, &Core::stolen, &Core::total, &Core::throttled})
      core.*count = minus(core.*count, before->second.*count);
  }
  return result;
}

}  // namespace sortie::firmware
