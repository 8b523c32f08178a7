// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/delay_evidence.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace sortie::rt::posix {

SetupResult Heartbeat::open_for_this_thread() noexcept {
  const SetupResult result = account_file_.open_for_this_thread();
  if (result.ok) static_cast<void>(account_file_.read(account_));
  return result;
}

void Heartbeat::beat(Nanoseconds planned_ns, Nanoseconds woke_ns) noexcept {
  ThreadAccount account = account_;
  if (account_file_.is_open()) static_cast<void>(account_file_.read(account));
  beat(planned_ns, woke_ns, account.run_queue_ns - account_.run_queue_ns);
  account_ = account;
}

CoreEvidence::~CoreEvidence() {
  for (const int file : files_) {
    if (file >= 0) close(file);
  }
}

SetupResult CoreEvidence::open() noexcept {
  files_[0] = ::open("/proc/interrupts", O_RDONLY | O_CLOEXEC);
  files_[1] = ::open("/proc/stat", O_RDONLY | O_CLOEXEC);
  read_steal();
  if (files_[0] >= 0 && files_[1] >= 0) return {};
  return refusal("causes of delays: %s cannot be read; interrupts will look like own work",
                 files_[0] < 0 ? "/proc/interrupts" : "/proc/stat");
}

void CoreEvidence::sample(Nanoseconds now_ns) noexcept {
  if (files_[0] >= 0) read_interrupts(now_ns);
  if (files_[1] >= 0) read_steal();
  sampled_ns_ = now_ns;
}

void CoreEvidence::read_interrupts(Nanoseconds now_ns) noexcept {
  const ssize_t got = pread(files_[0], text_, sizeof(text_) - 1, 0);
  if (got <= 0) return;
  text_[got] = '\0';
  // The first line names the cores of the columns: cores that are off have none.
  int core_of[kMaxCores];
  int columns = 0;
  char* line = text_;
  char* next = std::strchr(line, '\n');
  if (next == nullptr) return;
  *next = '\0';
  for (char* at = line; (at = std::strstr(at, "CPU")) != nullptr && columns < kMaxCores;) {
    at += 3;
    core_of[columns++] = static_cast<int>(std::strtol(at, nullptr, 10));
  }
  std::uint64_t counts[kMaxCores]{};
  for (line = next + 1; (next = std::strchr(line, '\n')) != nullptr; line = next + 1) {
    *next = '\0';
    char* at = std::strchr(line, ':');
    if (at == nullptr) continue;
    ++at;
    for (int column = 0; column < columns; ++column) {
      char* end = at;
      const auto number = std::strtoull(at, &end, 10);
      if (end == at) break;
      if (core_of[column] < kMaxCores) counts[core_of[column]] += number;
      at = end;
    }
  }
  const bool first = sampled_ns_ == 0;
  const double seconds = to_seconds(now_ns - sampled_ns_);
  for (int core = 0; core < kMaxCores; ++core) {
    const auto more = static_cast<double>(counts[core] - counts_[core]);
    counts_[core] = counts[core];
    if (first || seconds <= 0.0) continue;
    UsualRate& usual = usual_[core];
    usual.take(more / seconds);
    const double beyond = more - 2.0 * usual.per_s() * seconds - 30.0;
    if (beyond > 0.0) unusual_[core].add(sampled_ns_, now_ns, static_cast<std::uint64_t>(beyond));
    unusual_[core].cover(now_ns);
  }
}

void CoreEvidence::read_steal() noexcept {
  const ssize_t got = files_[1] < 0 ? 0 : pread(files_[1], text_, 255, 0);
  if (got <= 0) return;
  text_[got] = '\0';
  // cpu user nice system idle iowait irq softirq steal
  char* at = text_ + 3;
  unsigned long long field = 0;
  for (int i = 0; i < 8; ++i) field = std::strtoull(at, &at, 10);
  const long ticks = sysconf(_SC_CLK_TCK);
  if (field == 0 || ticks <= 0) return;
  stolen_ns_.store(static_cast<Nanoseconds>(field) * (kNanosecondsPerSecond / ticks),
                   std::memory_order_relaxed);
  steal_clock_.store(true, std::memory_order_relaxed);
}

}  // namespace sortie::rt::posix
