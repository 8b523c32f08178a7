// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/delay_cause.hpp"

namespace sortie::rt::posix {
namespace {

Nanoseconds at_least_zero(Nanoseconds value) { return value > 0 ? value : 0; }

// Takes as much of `wanted` out of `store` as there is.
Nanoseconds take(Nanoseconds& store, Nanoseconds wanted) {
  const Nanoseconds taken = store < wanted ? at_least_zero(store) : at_least_zero(wanted);
  store -= taken;
  return taken;
}

// part * whole / total without overflow for delays of any length: all three may be hours.
Nanoseconds share(Nanoseconds part, Nanoseconds whole, Nanoseconds total) {
  // Both factors below 2^31 after the shift: a relative error below 1e-8 that the caller evens out.
  int shift = 0;
  while ((total >> shift) >= (Nanoseconds{1} << 31) || (whole >> shift) >= (Nanoseconds{1} << 31)) ++shift;
  const Nanoseconds scaled_total = total >> shift;
  return scaled_total == 0 ? 0 : ((part >> shift) * (whole >> shift) / scaled_total) << shift;
}

}  // namespace

const char* to_string(DelayCause cause) {
  switch (cause) {
    case DelayCause::own:
      return "own work";
    case DelayCause::interrupt:
      return "interrupt";
    case DelayCause::run_queue:
      return "run queue";
    case DelayCause::stolen:
      return "stolen";
    case DelayCause::unknown:
      return "unknown";
  }
  return "no such cause";
}

Nanoseconds DelaySplit::total() const {
  Nanoseconds sum = 0;
  for (const Nanoseconds part : ns) sum += part;
  return sum;
}

DelayCause DelaySplit::main_cause() const {
  int best = static_cast<int>(DelayCause::unknown);
  for (int i = kDelayCauses - 1; i >= 0; --i) {
    if (ns[i] > 0 && ns[i] >= ns[best]) best = i;
  }
  return static_cast<DelayCause>(best);
}

DelaySplit DelaySplit::fitted_to(Nanoseconds late_ns) const {
  DelaySplit fitted;
  const Nanoseconds sum = total();
  if (late_ns <= 0) return fitted;
  if (sum <= late_ns) {
    fitted = *this;
    fitted[DelayCause::unknown] += late_ns - sum;
    return fitted;
  }
  Nanoseconds left = late_ns;
  for (int i = 0; i < kDelayCauses; ++i) left -= fitted.ns[i] = share(ns[i], late_ns, sum);
  // What rounding has left, or taken too much, belongs to the largest part.
  Nanoseconds& largest = fitted[main_cause()];
  largest += left;
  if (largest < 0) return DelaySplit{}.fitted_to(late_ns);
  return fitted;
}

DelaySplit split_delay(const DelaySample& sample) {
  DelaySplit split = sample.inherited;
  Nanoseconds pause = sample.pause_ns;
  Nanoseconds interrupts = Nanoseconds{sample.interrupts} * kInterruptCostNs;

  // Time that nobody was charged for. Without a context switch the core itself was away. With one, the thread
  // was stopped or it blocked: everybody's heart stood still, or it was the program's own call.
  const Nanoseconds uncharged = at_least_zero(sample.uncharged_ns);
  Nanoseconds blocked = sample.switched ? uncharged - take(pause, uncharged) : 0;
  if (!sample.switched) static_cast<void>(take(pause, uncharged));
  split[DelayCause::stolen] += uncharged - blocked;
  split[DelayCause::own] += blocked;

  // A timer that came late: a pause of everything, handlers that kept the core, or a core that was not there.
  Nanoseconds late_timer = at_least_zero(sample.timer_late_ns);
  split[DelayCause::stolen] += take(late_timer, take(pause, late_timer));
  split[DelayCause::interrupt] += take(late_timer, take(interrupts, late_timer));
  split[sample.guest_timer ? DelayCause::stolen : DelayCause::unknown] += late_timer;

  // A waiting thread that was charged: a handler ran in its name.
  Nanoseconds gap = at_least_zero(sample.disturbed_ns);
  if (sample.steal_charged) split[DelayCause::stolen] += take(gap, take(pause, gap));
  static_cast<void>(take(interrupts, gap));
  split[DelayCause::interrupt] += gap;

  // CPU time of the job beyond what it may use.
  Nanoseconds excess = at_least_zero(sample.charged_ns - sample.allowed_ns);
  if (sample.steal_charged) split[DelayCause::stolen] += take(excess, take(pause, excess));
  split[DelayCause::interrupt] += take(excess, take(interrupts, excess));
  split[DelayCause::own] += excess;

  // Ready, and kept waiting: by another thread, or by handlers that held the core before it was switched in.
  // What the handlers have not taken elsewhere they took here.
  Nanoseconds queued = at_least_zero(sample.run_queue_ns);
  split[DelayCause::interrupt] += take(queued, take(interrupts, queued));
  split[DelayCause::run_queue] += queued;
  return split.fitted_to(sample.late_ns);
}

}  // namespace sortie::rt::posix
