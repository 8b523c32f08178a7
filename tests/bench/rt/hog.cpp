// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/rt/hog.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

namespace sortie::bench {

namespace {

[[noreturn]] void be_busy() {
  constexpr std::size_t kBytes = std::size_t{8} << 20;
  std::vector<char> from(kBytes, 1);
  std::vector<char> to(kBytes);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  for (unsigned turn = 0;; ++turn) {
    std::memcpy(to.data(), from.data(), kBytes);
    from[turn % kBytes] = to[(turn * 4099u) % kBytes];
    for (int i = 0; i < 200; ++i) {
      if (write(nowhere, from.data(), 4096) < 0) _exit(1);
    }
  }
}

}  // namespace

Hogs::Hogs(const Settings&, int count) {
  for (int i = 0; i < count; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      be_busy();
    }
    if (child > 0) processes_.push_back(child);
  }
}

Hogs::~Hogs() {
  for (const pid_t process : processes_) kill(process, SIGKILL);
  for (const pid_t process : processes_) waitpid(process, nullptr, 0);
}

}  // namespace sortie::bench
