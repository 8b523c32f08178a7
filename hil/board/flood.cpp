// SPDX-License-Identifier: BSD-3-Clause
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <vector>

#include "drivers/can_socket.hpp"
#include "hil/board/board_jobs.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/heap_trap.hpp"
#include "rt/posix/realtime.hpp"

namespace sortie::hil {

namespace {

constexpr std::uint32_t kOut = 0x101;
constexpr std::uint32_t kBack = 0x102;
constexpr std::uint32_t kQuietReleases = 200;  // without an answer: the rest is lost
constexpr int kBufferBytes = 1 << 18;
constexpr std::size_t kStackBytes = 1 << 17;

bool open_port(drivers::SocketCan& port, const std::string& interface, std::uint32_t id) {
  drivers::SocketCanConfig config;
  config.interface = interface;
  config.filters = {{id, 0x7FF, false}};
  config.receive_buffer_bytes = kBufferBytes;
  std::string problem;
  if (port.open(config, problem) == Status::ok) return true;
  complain(problem);
  return false;
}

bool become_realtime(int priority) {
  const rt::posix::SetupResult stack = rt::posix::prefault_stack(kStackBytes);
  if (!stack.ok) complain(stack.reason);
  const rt::posix::SetupResult locked = rt::posix::lock_memory();
  const rt::posix::SetupResult fifo = rt::posix::set_fifo_priority(priority);
  if (!locked.ok || !fifo.ok) complain(locked.ok ? fifo.reason : locked.reason);
  return locked.ok && fifo.ok;
}

// Sends every frame back under the other identifier, until it is killed. `shown` is shared with the parent.
void answer(const FloodConfig& config, drivers::CanCounters& shown) {
  drivers::SocketCan port;
  if (!open_port(port, config.far, kOut) || !become_realtime(10)) ::_exit(1);
  pollfd wait{port.descriptor(), POLLIN, 0};
  drivers::CanFrame frame;
  for (;;) {
    ::poll(&wait, 1, -1);
    while (port.receive(frame) == Status::ok) {
      frame.id = kBack;
      while (port.send(frame) == Status::full) rt::posix::sleep_until(rt::posix::monotonic_now() + 20000);
    }
    shown = port.counters();
  }
}

struct Tally {
  std::uint32_t sent{};
  std::uint32_t received{};
  std::uint32_t out_of_order{};
  std::uint32_t quiet{};
};

void take_answers(drivers::SocketCan& port, Tally& tally) {
  drivers::CanFrame frame;
  ++tally.quiet;
  while (port.receive(frame) == Status::ok) {
    if ((frame.flags & drivers::kCanError) != 0) continue;
    std::uint32_t number = 0;
    std::memcpy(&number, frame.data, sizeof number);
    if (number != tally.received) ++tally.out_of_order;
    ++tally.received;
    tally.quiet = 0;
  }
}

void send_some(drivers::SocketCan& port, const FloodConfig& config, Tally& tally) {
  drivers::CanFrame frame;
  frame.id = kOut;
  frame.size = 8;
  for (std::uint32_t i = 0; i < config.per_ms && tally.sent < config.frames; ++i) {
    std::memcpy(frame.data, &tally.sent, sizeof tally.sent);
    if (port.send(frame) != Status::ok) return;  // full: the same one again at the next release
    ++tally.sent;
  }
}

int report(std::vector<std::int64_t>& late, const Tally& tally, const drivers::CanCounters& counters,
           const drivers::CanCounters& far, std::uint64_t heap_calls, std::uint64_t page_faults,
           std::int64_t work_max_ns, const FloodConfig& config) {
  std::sort(late.begin(), late.end());
  const auto at = [&late](std::size_t share) {
    return static_cast<long long>(late[(late.size() - 1) * share / 1000]);
  };
  const auto count = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
  std::printf(
      "{\"near\": \"%s\", \"far\": \"%s\", \"sent\": %u, \"received\": %u, \"lost\": %u, \"out_of_order\": "
      "%u, ",
      config.near.c_str(), config.far.c_str(), tally.sent, tally.received, config.frames - tally.received,
      tally.out_of_order);
  std::printf(
      "\"refused\": %llu, \"overrun\": %llu, \"far_received\": %llu, \"far_overrun\": %llu, \"heap_calls\": "
      "%llu, \"page_faults\": %llu, ",
      count(counters.tx_refused), count(counters.rx_overrun), count(far.received), count(far.rx_overrun),
      count(heap_calls), count(page_faults));
  std::printf("\"releases\": %llu, \"late_min_ns\": %lld, \"late_p50_ns\": %lld, \"late_p99_ns\": %lld, ",
              count(late.size()), at(0), at(500), at(990));
  std::printf("\"late_max_ns\": %lld, \"work_max_ns\": %lld}\n", at(1000),
              static_cast<long long>(work_max_ns));
  return tally.received == config.frames && tally.out_of_order == 0 && heap_calls == 0 ? 0 : 1;
}

}  // namespace

int flood(const FloodConfig& config) {
  drivers::SocketCan port;
  if (!open_port(port, config.near, kBack)) return 1;
  void* const shared = ::mmap(nullptr, sizeof(drivers::CanCounters), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) return 1;
  auto* const far_counters = new (shared) drivers::CanCounters{};
  const pid_t far = ::fork();
  if (far < 0) return complain("no process");  // and nobody to be killed: kill(-1) is everybody
  if (far == 0) answer(config, *far_counters);
  const std::size_t most = 2 * std::size_t{config.frames} / std::max(config.per_ms, 1U) + 2 * kQuietReleases;
  std::vector<std::int64_t> late;
  late.reserve(most);
  Tally tally;
  std::int64_t work_max_ns = 0;
  std::uint64_t heap_calls = 0;
  const bool ready = become_realtime(80);
  const rt::posix::PageFaults before = rt::posix::thread_page_faults();
  rt::Nanoseconds release_ns = rt::posix::monotonic_now() + 100 * rt::kNanosecondsPerMillisecond;
  if (ready) {
    const rt::posix::HeapTrapScope heap;
    while (tally.received < config.frames && tally.quiet < kQuietReleases && late.size() < most) {
      rt::posix::sleep_until(release_ns);
      const rt::Nanoseconds woke_ns = rt::posix::monotonic_now();
      late.push_back(woke_ns - release_ns);
      take_answers(port, tally);
      send_some(port, config, tally);
      work_max_ns = std::max(work_max_ns, rt::posix::monotonic_now() - woke_ns);
      release_ns += rt::kNanosecondsPerMillisecond;
    }
    heap_calls = heap.calls();
  }
  const rt::posix::PageFaults after = rt::posix::thread_page_faults();
  static_cast<void>(rt::posix::set_ordinary_priority().ok);
  ::kill(far, SIGKILL);
  ::waitpid(far, nullptr, 0);
  if (!ready || late.empty()) return 1;
  return report(late, tally, port.counters(), *far_counters, heap_calls,
                static_cast<std::uint64_t>(after.minor + after.major - before.minor - before.major),
                work_max_ns, config);
}

}  // namespace sortie::hil
