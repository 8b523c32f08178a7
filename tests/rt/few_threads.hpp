// SPDX-License-Identifier: BSD-3-Clause
// A process that the system gives little: few threads, as under `ulimit -u` or a container's limit, or no
// high priority.
#pragma once

#include <grp.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace sortie::testing {

inline constexpr int kNotPossible = 77;  ///< the limit cannot be set here
inline constexpr int kHung = 78;         ///< it did not end within 20 s

/// The exit code of a child of this process that calls `limit`, a bool(), and then runs `body`, an int();
/// -signal if it was killed. As root the child becomes a user that nobody else is, for whom limits hold and
/// who has no other threads.
template <class Limit, class Body>
int limited(Limit limit, Body body) {
  const pid_t child = fork();
  if (child == 0) {
    // A number that is as good as never given to anybody, and another for each child.
    const auto user = static_cast<uid_t>(1'500'000'000 + getpid());
    if (!limit()) _exit(kNotPossible);
    if (geteuid() == 0 &&
        (setgroups(0, nullptr) != 0 || setresgid(user, user, user) != 0 || setresuid(user, user, user) != 0))
      _exit(kNotPossible);
    alarm(20);
    _exit(body());
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return kNotPossible;
  if (WIFSIGNALED(status)) return WTERMSIG(status) == SIGALRM ? kHung : -WTERMSIG(status);
  return WEXITSTATUS(status);
}

/// Sets both limits of a resource.
inline bool set_limit(decltype(RLIMIT_NPROC) resource, rlim_t most) {
  const rlimit limit{most, most};
  return setrlimit(resource, &limit) == 0;
}

/// limited() to `most` threads, the child's first one counted. Of a user that is not root the other threads
/// count, too.
template <class Body>
int few_threads(int most, Body body) {
  return limited([most] { return set_limit(RLIMIT_NPROC, static_cast<rlim_t>(most)); }, body);
}

}  // namespace sortie::testing
