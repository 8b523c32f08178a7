// SPDX-License-Identifier: BSD-3-Clause
// The first process of an emulated board: a worker at 1 kHz under its delay observer, while the board is
// paused from outside. Prints each delay with its causes, then switches the board off.
#include <sys/mount.h>
#include <sys/reboot.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "tests/rt/cause_confusion.hpp"

using namespace sortie::rt::posix;
using namespace sortie::rt::posix::test;

int main() {
  mkdir("/proc", 0755);
  mkdir("/sys", 0755);
  mount("proc", "/proc", "proc", 0, nullptr);
  mount("sysfs", "/sys", "sysfs", 0, nullptr);
  const char* text = std::getenv("seconds");  // from the kernel's command line
  const double seconds = text == nullptr ? 10.0 : std::atof(text);
  {
    // The other way round: work of its own must not be taken for a pause.
    SharedResult result;
    CauseRig(Injection::own_work, 1, 5.0, *result).run();
    const ConfusionRow row = judge(*result);
    std::printf("OWN-WORK %u %u", row.injected, row.outliers);
    for (const auto count : row.label) std::printf(" %u", count);
    std::printf(" %lld %lld\n", static_cast<long long>(row.total_ns), static_cast<long long>(row.unknown_ns));
  }
  std::printf("BOARD-READY\n");
  std::fflush(stdout);
  {
    SharedResult result;
    CauseRig(Injection::none, 1, seconds, *result).run();
    for (std::uint32_t i = 0; i < result->outlier_count; ++i) {
      const DelayOutlier& outlier = result->outliers[i];
      std::printf("DELAY %s %lld", outlier.kind == DelayKind::start ? "start" : "execution",
                  static_cast<long long>(outlier.late_ns));
      for (const auto part : outlier.split.ns) std::printf(" %lld", static_cast<long long>(part));
      std::printf("\n");
    }
    std::printf("BOARD-END jobs %u skipped %u refused %s\n", result->jobs, result->skipped,
                result->refused[0] == '\0' ? "nothing" : result->refused);
  }
  std::fflush(stdout);
  sync();
  if (getpid() == 1) reboot(RB_POWER_OFF);
  return 0;
}
