// SPDX-License-Identifier: BSD-3-Clause
#include <poll.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "drivers/can_link.hpp"
#include "drivers/can_socket.hpp"
#include "drivers/candump.hpp"
#include "hil/board/board_jobs.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::hil {

namespace {

std::atomic<bool> watch_ended{false};

// The parent of run_isolated(): gives the interface away when the child has a network of its own.
int hand_over(const std::string& interface, pid_t child, int ready, int given) {
  char byte = 0;
  std::string problem;
  if (::read(ready, &byte, 1) != 1) return complain("the program got no network of its own");
  if (!drivers::move_can_to(interface, child, problem)) {
    ::kill(child, SIGKILL);
    return complain(problem);
  }
  if (::write(given, &byte, 1) != 1) return complain("the program went away");
  return 0;
}

}  // namespace

int complain(const std::string& problem) {
  std::fprintf(stderr, "sortie_board: %s\n", problem.c_str());
  return 1;
}

int run_isolated(const std::string& interface, std::uint32_t bits_per_s, char** program) {
  int ready[2];
  int given[2];
  if (::pipe(ready) != 0 || ::pipe(given) != 0) return complain("no pipe");
  const pid_t self = ::getpid();
  const pid_t helper = ::fork();  // the helper stays outside, so that this process is the program
  if (helper < 0) return complain("no process");
  if (helper == 0) {
    ::close(ready[1]);  // else it would wait for itself where the program goes away
    ::_exit(hand_over(interface, self, ready[0], given[1]));
  }
  char byte = 0;
  std::string problem;
  if (::unshare(CLONE_NEWNET) != 0)
    return complain("no network namespace: " + std::string(std::strerror(errno)));
  if (::write(ready[1], &byte, 1) != 1 || ::read(given[0], &byte, 1) != 1)
    return complain(interface + " was not given");
  ::waitpid(helper, nullptr, 0);
  if (!drivers::switch_on("lo", problem) || !drivers::set_can_bitrate(interface, bits_per_s, problem))
    return complain(problem);
  ::execv(program[0], program);
  return complain(std::string(program[0]) + ": " + std::strerror(errno));
}

int watch_bus(const std::string& interface, const std::string& file) {
  drivers::SocketCan port;
  drivers::SocketCanConfig config;
  config.interface = interface;
  config.receive_buffer_bytes = 1 << 22;
  std::string problem;
  if (port.open(config, problem) != Status::ok) return complain(problem);
  std::signal(SIGTERM, [](int) { watch_ended.store(true); });
  drivers::CandumpWriter writer(file, drivers::CandumpDigits::nano);
  pollfd wait{port.descriptor(), POLLIN, 0};
  drivers::CanFrame frame;
  while (!watch_ended.load()) {
    ::poll(&wait, 1, 10);
    while (port.receive(frame) == Status::ok) {
      if (writer.write(frame, interface) != Status::ok) return complain(file + ": cannot be written");
    }
  }
  if (writer.close() != Status::ok) return complain(file + ": cannot be written");
  const drivers::CanCounters counters = port.counters();
  std::printf("{\"frames\": %llu, \"overrun\": %llu}\n", static_cast<unsigned long long>(writer.frames()),
              static_cast<unsigned long long>(counters.rx_overrun));
  return 0;
}

int kill_process(int process) {
  const rt::Nanoseconds now_ns = rt::posix::monotonic_now();
  if (process <= 1 || ::kill(process, SIGKILL) != 0) return complain("no such process");
  std::printf("{\"killed_s\": %.9f}\n", static_cast<double>(now_ns) * 1e-9);
  return 0;
}

}  // namespace sortie::hil
