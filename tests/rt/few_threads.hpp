// SPDX-License-Identifier: BSD-3-Clause
// Processes of their own for what would leave its mark on this one, and such that the system gives few
// threads, as under `ulimit -u` or a container's limit.
#pragma once

#include <grp.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>

namespace sortie::testing {

inline constexpr int kNotPossible = 77;  ///< the limit cannot be set here
inline constexpr int kHung = 78;         ///< it did not end within two minutes

/// The exit code of a child of this process that runs `body`, an int(); -signal if it was killed.
template <class Body>
int in_child(Body body) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(120);  // no promise: whoever locks a large process's memory on a busy machine takes seconds
    // What is thrown here must not go on as a second run of all tests.
    _exit([&body]() noexcept { return body(); }());
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return kNotPossible;
  if (WIFSIGNALED(status)) return WTERMSIG(status) == SIGALRM ? kHung : -WTERMSIG(status);
  return WEXITSTATUS(status);
}

/// in_child() with `most` threads at most, its first one counted. As root the child becomes a user that
/// nobody else is, for whom the limit holds and who has no other threads; else the user's other threads
/// count, too.
template <class Body>
int few_threads(int most, Body body) {
  return in_child([most, body] {
    // A number that is as good as never given to anybody, and another for each child.
    const auto user = static_cast<uid_t>(1'500'000'000 + getpid());
    const rlimit limit{static_cast<rlim_t>(most), static_cast<rlim_t>(most)};
    if (setrlimit(RLIMIT_NPROC, &limit) != 0) return kNotPossible;
    if (geteuid() == 0 &&
        (setgroups(0, nullptr) != 0 || setresgid(user, user, user) != 0 || setresuid(user, user, user) != 0))
      return kNotPossible;
    return body();
  });
}

/// Runs `body` with 1 to `most` threads: it returns 0 where it ran and 10 where it was refused with the cure.
/// As root, where nobody else's threads count, it must have run with `needed` of them and more, and with no
/// fewer.
template <class Body>
void check_few_threads(int most, int needed, Body body) {
  int refused = 0;
  for (int threads = 1; threads <= most; ++threads) {
    INFO("a system that gives " << threads << " threads");
    const int code = few_threads(threads, body);
    if (code == kNotPossible) {
      WARN("skipped: this user's threads cannot be limited");
      return;
    }
    CHECK((code == 0 || code == 10));
    refused += code == 10 ? 1 : 0;
#if !defined(__SANITIZE_THREAD__)  // it has a thread of its own
    if (geteuid() == 0) CHECK(code == (threads < needed ? 10 : 0));
#else
    static_cast<void>(needed);
#endif
  }
  CHECK(refused >= 1);
}

}  // namespace sortie::testing
