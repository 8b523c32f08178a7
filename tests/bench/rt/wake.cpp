// SPDX-License-Identifier: BSD-3-Clause
// Lateness of wake-ups at 1 kHz: ours, a plain sleep and cyclictest in alternating slices, so that a rough
// moment of the machine meets all of them.
#include <algorithm>

#include "tests/bench/rt/hog.hpp"
#include "tests/bench/rt/measure.hpp"
#include "tests/bench/rt/wake_slices.hpp"

namespace sortie::bench {

namespace {

constexpr double kShares[] = {0.5, 0.99, 0.999, 1.0};
constexpr const char* kNames[] = {"p50", "p99", "p99.9", "max"};

double us(std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; }

// The share q of all latencies is at most this; what lies beyond the histogram counts as the largest.
double quantile_us(const CyclictestSlice& slice, double share) {
  std::uint64_t n = slice.overflows;
  for (const std::uint64_t count : slice.bins_us) n += count;
  const auto rank = static_cast<std::uint64_t>(std::max(1.0, share * static_cast<double>(n) + 0.999999));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; share < 1 && i < slice.bins_us.size(); ++i) {
    seen += slice.bins_us[i];
    if (seen >= rank) return static_cast<double>(i);
  }
  return static_cast<double>(slice.max_us);
}

struct Method {
  WakeSamples all;
  Rounds by_share[4];
  Rounds spun;
  void take(const WakeSamples& slice) {
    all.add(slice);
    for (int i = 0; i < 4; ++i) by_share[i].add(us(slice.raw.percentile(kShares[i])));
    spun.add(100 * slice.spun_s / slice.wall_s);
  }
};

// The whole run's figure, and how it went from slice to slice.
Json whole(double value, const Rounds& rounds) {
  return {{"value", value}, {"low", rounds.low()}, {"high", rounds.high()}};
}

// Why ours were late: by positive evidence, or unknown.
void add_causes(const WakeSamples& all, Report& report) {
  Figure clean;
  clean.group = "wake-up";
  clean.what = "lateness, clean max";
  clean.unit = "us";
  clean.n = all.raw.count();
  clean.ours = spread(us(all.clean_max_ns));
  report.add(clean);
  rt::Nanoseconds total = 0;
  std::uint64_t n = 0;
  std::string words = "ours later than 100 us, by cause:";
  for (int i = 0; i < rt::posix::kDelayCauses; ++i) {
    const auto cause = static_cast<rt::posix::DelayCause>(i);
    total += all.late_ns[i];
    n += all.late[i];
    words += std::string(i == 0 ? " " : ", ") + to_string(cause) + " " + std::to_string(all.late[i]) + " (" +
             std::to_string(all.late_ns[i] / 1000) + " us)";
  }
  report.note("wake-up", words);
  Figure unknown;
  unknown.group = "wake-up";
  unknown.what = "lateness above 100 us of unknown cause";
  unknown.unit = "%";
  unknown.n = n;
  const double share =
      total == 0 ? 0
                 : 100 * static_cast<double>(all.late_ns[static_cast<int>(rt::posix::DelayCause::unknown)]) /
                       static_cast<double>(total);
  unknown.ours = spread(share);
  set_goal(unknown, "<= 5 %", share <= 5);
  report.add(unknown);
}

}  // namespace

void measure_wake(const Settings& settings, Report& report) {
  say("wake-ups at 1 kHz, " + std::to_string(settings.rounds) + " rounds of alternating slices");
  const Hogs hogs(settings, settings.load);
  const Witnesses witnesses(settings);
  Method ours;
  Method sleep;
  rt::posix::SpinMargin margin;
  CyclictestSlice peer_all;
  Rounds peer[4];
  for (int round = 0; round < settings.rounds; ++round) {
    WakeSamples slice;
    wake_by_sortie(settings, witnesses, margin, slice);
    ours.take(slice);
    if (peer_all.problem.empty()) {
      const CyclictestSlice theirs = run_cyclictest(settings);
      peer_all.problem = theirs.problem;
      peer_all.bins_us.resize(std::max(peer_all.bins_us.size(), theirs.bins_us.size()));
      for (std::size_t i = 0; i < theirs.bins_us.size(); ++i) peer_all.bins_us[i] += theirs.bins_us[i];
      peer_all.overflows += theirs.overflows;
      peer_all.max_us = std::max(peer_all.max_us, theirs.max_us);
      for (int i = 0; i < 4; ++i) peer[i].add(quantile_us(theirs, kShares[i]));
    }
    WakeSamples plain;
    wake_by_sleep(settings, plain);
    sleep.take(plain);
  }
  const bool has_peer = peer_all.problem.empty();
  if (!has_peer) report.skip("cyclictest", peer_all.problem);

  for (int i = 0; i < 4; ++i) {
    Figure figure;
    figure.group = "wake-up";
    figure.what = std::string("lateness, raw ") + kNames[i];
    figure.unit = "us";
    figure.n = ours.all.raw.count();
    const double value = us(ours.all.raw.percentile(kShares[i]));
    figure.ours = whole(value, ours.by_share[i]);
    if (has_peer) {
      const double theirs = quantile_us(peer_all, kShares[i]);
      figure.peer = "cyclictest";
      figure.theirs = whole(theirs, peer[i]);
      figure.ratio = whole(theirs > 0 ? value / theirs : 0, ratio(ours.by_share[i], peer[i]));
      if (i == 0) set_goal(figure, "ratio <= 0.01", value <= 0.01 * theirs);
      if (i == 1) set_goal(figure, "ratio <= 0.25", value <= 0.25 * theirs);
    }
    report.add(figure);
    const double slept = us(sleep.all.raw.percentile(kShares[i]));
    figure.peer = "clock_nanosleep";
    figure.theirs = whole(slept, sleep.by_share[i]);
    figure.ratio = whole(value / slept, ratio(ours.by_share[i], sleep.by_share[i]));
    figure.goal.clear();
    report.add(figure);
  }
  add_causes(ours.all, report);
  Figure spinning;
  spinning.group = "wake-up";
  spinning.what = "CPU spent spinning";
  spinning.unit = "%";
  spinning.n = ours.all.raw.count();
  const double share = 100 * ours.all.spun_s / ours.all.wall_s;
  spinning.ours = whole(share, ours.spun);
  set_goal(spinning, "<= 6 %", share <= 6);
  report.add(spinning);
  report.add_distribution("sortie", ours.all.raw);
  report.add_distribution("clock_nanosleep", sleep.all.raw);
  if (has_peer) report.add_distribution("cyclictest", peer_all.bins_us, peer_all.max_us);
}

}  // namespace sortie::bench
