// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/thread_account.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace sortie::rt::posix {
namespace {

// One decimal number and the byte behind it; null when there is none.
const char* read_number(const char* text, std::uint64_t& number) {
  if (*text < '0' || *text > '9') return nullptr;
  number = 0;
  while (*text >= '0' && *text <= '9') number = number * 10 + static_cast<std::uint64_t>(*text++ - '0');
  return *text == '\0' ? text : text + 1;
}

}  // namespace

ThreadAccountFile::~ThreadAccountFile() {
  if (file_ >= 0) close(file_);
}

SetupResult ThreadAccountFile::open_for_this_thread() noexcept {
  if (file_ >= 0) close(file_);
  file_ = open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC);
  ThreadAccount account;
  if (file_ >= 0 && read(account)) return {};
  const SetupResult result = refusal(
      "causes of delays: /proc/thread-self/schedstat: %s; mount /proc, or use a kernel with "
      "CONFIG_SCHED_INFO",
      file_ < 0 ? std::strerror(errno) : "holds no numbers");
  if (file_ >= 0) close(file_);
  file_ = -1;
  return result;
}

bool ThreadAccountFile::read(ThreadAccount& account) const noexcept {
  char text[96];
  const ssize_t got = pread(file_, text, sizeof(text) - 1, 0);
  if (got <= 0) return false;
  text[got] = '\0';
  std::uint64_t cpu = 0;
  std::uint64_t waited = 0;
  std::uint64_t switched_in = 0;
  const char* at = read_number(text, cpu);
  if (at != nullptr) at = read_number(at, waited);
  if (at != nullptr) at = read_number(at, switched_in);
  if (at == nullptr) return false;
  account = {static_cast<Nanoseconds>(cpu), static_cast<Nanoseconds>(waited), switched_in};
  return true;
}

std::uint64_t voluntary_switches() noexcept {
  rusage usage{};
  return getrusage(RUSAGE_THREAD, &usage) == 0 ? static_cast<std::uint64_t>(usage.ru_nvcsw) : 0;
}

}  // namespace sortie::rt::posix
