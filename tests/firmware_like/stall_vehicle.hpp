// SPDX-License-Identifier: BSD-3-Clause
// A vehicle made to miss deadlines: two groups that read each other, tasks that stall by job number, and a
// driver that delivers bursts. Its samples have no message type of their own.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "firmware_like/runtime/vehicle.hpp"
#include "tests/firmware_like/temp_folder.hpp"

namespace sortie::testing {

/// A sample of a user's own type.
struct Reading {
  rt::Nanoseconds stamp_ns{};
  std::uint32_t value{};

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("value", self.value);
  }
};

/// Output of both tasks: a sum over all that was seen, in the order in which it was seen.
struct Mixed {
  std::uint64_t sum{};
  std::uint32_t samples{};
  std::uint32_t others{};

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("sum", self.sum);
    visit("samples", self.samples);
    visit("others", self.others);
  }
};

/// How long jobs take; set before a run. In a replay the times must not matter.
struct Stalls {
  int fast_us{};          ///< every 37th fast job
  int slow_us{};          ///< every 5th slow job
  std::uint32_t burst{};  ///< readings at once, every 50th call of the driver
};
inline Stalls stalls;

/// What the tasks of a run have done so far, counted by themselves: how much that is in a second is the
/// machine's business.
struct StallCounts {
  std::atomic<std::uint32_t> jobs{0};          ///< of both groups
  std::atomic<std::uint32_t> fast_stalled{0};  ///< jobs that stalled
  std::atomic<std::uint32_t> slow_stalled{0};
};
inline StallCounts stall_counts;

class StallVehicle final : public firmware::Vehicle {
 public:
  explicit StallVehicle(firmware::VehicleBuilder& builder) {
    const rt::GroupId fast = builder.group("fast", 1000);
    const rt::GroupId slow = builder.group("slow", 50);
    std::tie(fast_stream_, fast_port_) = builder.stream<Reading>(fast, "SORTIE_CUSTOM_fast", 64, 16);
    std::tie(slow_stream_, slow_port_) = builder.stream<Reading>(slow, "SORTIE_CUSTOM_slow", 64, 32);
    fast_task_ = builder.task<Mixed>(fast, "quick", 200, [this](rt::JobContext& context, Mixed& mixed) {
      mix(context, mixed, *fast_stream_, *fast_input_);
      if (context.job % 37 == 5) stall(stalls.fast_us, stall_counts.fast_stalled);
    });
    slow_task_ = builder.task<Mixed>(slow, "heavy", 5000, [this](rt::JobContext& context, Mixed& mixed) {
      mix(context, mixed, *slow_stream_, *slow_input_);
      if (context.job % 5 == 3) stall(stalls.slow_us, stall_counts.slow_stalled);
    });
    builder.remembers(fast_task_);
    builder.remembers(slow_task_);
    fast_input_ = builder.input(fast, slow_task_, 2);
    slow_input_ = builder.input(slow, fast_task_, 32);
    builder.check();
  }

  void poll_devices(const firmware::Devices&, rt::Nanoseconds now_ns) override {
    const std::uint32_t count = ++calls_ % 50 == 7 ? 1 + stalls.burst : 1;
    for (std::uint32_t i = 0; i < count; ++i) {
      next_ = next_ * 1664525u + 1013904223u;
      // What does not fit is refused and counted, and must not be in the log either.
      static_cast<void>(fast_port_->push({now_ns, next_}, now_ns));
      static_cast<void>(slow_port_->push({now_ns, next_ ^ 0x5555u}, now_ns));
    }
  }

 private:
  static void stall(int us, std::atomic<std::uint32_t>& count) {
    if (us <= 0) return;
    std::this_thread::sleep_for(std::chrono::microseconds(us));
    count.fetch_add(1, std::memory_order_relaxed);
  }
  static void mix(const rt::JobContext& context, Mixed& mixed, const rt::Stream<Reading>& readings,
                  const rt::Input<Mixed>& others) {
    for (const Reading& reading : readings) {
      mixed.sum = mixed.sum * 31 + reading.value + static_cast<std::uint64_t>(reading.stamp_ns);
      ++mixed.samples;
    }
    for (const Mixed& other : others) {
      mixed.sum = mixed.sum * 37 + other.sum;
      ++mixed.others;
    }
    mixed.sum = mixed.sum * 41 + context.job;
    stall_counts.jobs.fetch_add(1, std::memory_order_relaxed);
  }

  rt::Stream<Reading>* fast_stream_{};
  rt::Stream<Reading>* slow_stream_{};
  firmware::InputPort<Reading>* fast_port_{};
  firmware::InputPort<Reading>* slow_port_{};
  rt::Task<Mixed>* fast_task_{};
  rt::Task<Mixed>* slow_task_{};
  rt::Input<Mixed>* fast_input_{};
  rt::Input<Mixed>* slow_input_{};
  std::uint32_t calls_{};
  std::uint32_t next_{1};
};

inline firmware::VehicleRegistry stall_vehicles() {
  return {{"stall", [](firmware::VehicleBuilder& builder) -> std::unique_ptr<firmware::Vehicle> {
             return std::make_unique<StallVehicle>(builder);
           }}};
}

/// Writes the vehicle's scene into a folder and gives its path.
inline std::string stall_scene(const TempFolder& folder) {
  return folder.write("stall.toml", "[scene]\nname = \"stall\"\nvehicle = \"stall\"\n");
}

}  // namespace sortie::testing
