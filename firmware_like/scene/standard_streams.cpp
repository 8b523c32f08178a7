// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/standard_streams.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>

namespace sortie::firmware {
namespace {

bool output_was_closed = false;

bool is_closed(int descriptor) { return fcntl(descriptor, F_GETFD) < 0 && errno == EBADF; }

}  // namespace

void prepare_standard_streams() noexcept {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (!is_closed(descriptor)) continue;
    if (descriptor == STDOUT_FILENO) output_was_closed = true;
    // open() takes the lowest number that is free: this one. Output for reading only: every write is an
    // error.
    static_cast<void>(open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY));
  }
}

std::string standard_output_problem() {
  errno = 0;
  std::cout.flush();
  bool good = std::fflush(stdout) == 0 && std::cout.good() && std::ferror(stdout) == 0;
  int reason = errno;
  if (good && !output_was_closed) {  // a network disk that is full says so only at the end
    errno = 0;
    const int copy = dup(STDOUT_FILENO);
    good = copy < 0 || close(copy) == 0 || errno == EINTR;
    reason = errno;
  }
  if (good) return {};
  const std::string why = output_was_closed ? "it is closed"
                          : reason != 0     ? std::strerror(reason)
                                            : "it is full, or its reader has gone";
  return "standard output: cannot be written (" + why + "); what this command was to print is lost";
}

}  // namespace sortie::firmware
