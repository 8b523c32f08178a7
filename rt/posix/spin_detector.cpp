// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/spin_detector.hpp"

#include "rt/posix/clock.hpp"
#include "rt/posix/fast_clock.hpp"

namespace sortie::rt::posix {

void spin_and_watch(Nanoseconds duration_ns, SpinNoise& noise, Nanoseconds gap_ns) noexcept {
  const Nanoseconds cpu = thread_cpu_now();
  const Nanoseconds start = fast_now();
  Nanoseconds before = start;
  while (before - start < duration_ns) {
    const Nanoseconds now = fast_now();
    if (now - before > gap_ns) {
      noise.gaps.record(static_cast<std::uint64_t>(now - before));
      noise.lost_ns += now - before;
    }
    before = now;
  }
  const Nanoseconds spun = before - start;
  const Nanoseconds charged = thread_cpu_now() - cpu;
  noise.spun_ns += spun;
  if (spun > charged) noise.uncharged_ns += spun - charged;
}

}  // namespace sortie::rt::posix
