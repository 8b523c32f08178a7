// SPDX-License-Identifier: BSD-3-Clause
// The observer's book-keeping on an ordinary thread, anywhere: every delay is counted once, its parts add up,
// and no case waits for ever for a witness. Whether causes are right is the business of cause_test.
#include "rt/posix/delay_observer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <thread>

#include "rt/posix/housekeeper.hpp"
#include "tests/rt/burn.hpp"

namespace sortie::rt::posix {
namespace {

using test::burn;
using test::kMs;

// `ticks` jobs at 2 ms; every tenth works for 3 ms with a budget of 1 ms. False where there is no account.
bool run(DelayObserver& observer, const DelayOptions& options, Tick ticks) {
  bool opened = false;
  std::thread([&] {
    if (!observer.open(options).ok) return;
    opened = true;
    const Nanoseconds start = monotonic_now() + 5 * kMs;
    for (Tick tick = 0; tick < ticks; ++tick) {
      const Nanoseconds release = start + static_cast<Nanoseconds>(tick) * 2 * kMs;
      const ReleaseWait wait = wait_for_release(observer, tick, release, 50'000);
      CHECK(wait.woke_ns >= release);
      if (tick % 10 == 5) burn(3 * kMs);
      observer.after_job(tick, wait.woke_ns, monotonic_now(), kMs);
    }
  }).join();
  return opened;
}

void check_books(const DelayStatistics& statistics, Tick ticks) {
  CHECK(statistics.failed_readings == 0);
  CHECK(statistics.outliers == statistics.start.outliers + statistics.execution.outliers);
  for (const DelayTable* table : {&statistics.start, &statistics.execution}) {
    CHECK(table->raw.count() == ticks);
    CHECK(table->clean_max_ns <= table->raw.max());
    std::uint64_t outside = 0;
    std::uint64_t outliers = 0;
    for (int cause = 0; cause < kDelayCauses; ++cause) {
      outliers += table->count[cause];
      const auto name = static_cast<DelayCause>(cause);
      if (name != DelayCause::own && name != DelayCause::unknown) outside += table->count[cause];
    }
    CHECK(outliers == table->outliers);
    CHECK(table->clean_count + outside == ticks);
  }
  const std::uint64_t kept = std::min<std::uint64_t>(statistics.outliers, DelayStatistics::kLast);
  for (std::uint64_t i = statistics.outliers - kept; i < statistics.outliers; ++i) {
    const DelayOutlier& outlier = statistics.last[i % DelayStatistics::kLast];
    CHECK(outlier.late_ns > 100'000);
    CHECK(outlier.split.total() == outlier.late_ns);
    CHECK(std::all_of(std::begin(outlier.split.ns), std::end(outlier.split.ns),
                      [](auto part) { return part >= 0; }));
  }
}

}  // namespace

TEST_CASE("every delay is counted once and its parts add up") {
  const auto observer = std::make_unique<DelayObserver>();
  Housekeeper keeper;
  static_cast<void>(keeper.start());
  DelayOptions options;
  options.cores = &keeper.evidence();
  constexpr Tick kTicks = 100;
  if (!run(*observer, options, kTicks)) {
    WARN("skipped: the kernel keeps no account of threads");
    return;
  }
  keeper.stop();
  observer->finish();
  const DelayStatistics& statistics = observer->statistics();
  check_books(statistics, kTicks);
  CHECK(statistics.execution.outliers >= kTicks / 10);
  CHECK(statistics.start.outliers >= kTicks / 10);  // 3 ms of work in a period of 2 ms delay the next start
  CHECK(statistics.without_evidence <
        statistics.outliers);  // on a busy machine the housekeeper itself is late
  const std::uint64_t before = statistics.outliers;
  observer->finish();
  CHECK(statistics.outliers == before);
}

TEST_CASE("a witness that never speaks holds no case up for ever and each such case is told") {
  const auto observer = std::make_unique<DelayObserver>();
  const auto silent = std::make_unique<Heartbeat>();
  DelayOptions options;
  options.heart = silent.get();
  constexpr Tick kTicks = 300;  // far more delays than there is room for open cases
  if (!run(*observer, options, kTicks)) {
    WARN("skipped: the kernel keeps no account of threads");
    return;
  }
  observer->finish();
  const DelayStatistics& statistics = observer->statistics();
  check_books(statistics, kTicks);
  CHECK(statistics.outliers >= 2 * kTicks / 10);
  CHECK(statistics.without_evidence == statistics.outliers);
}

TEST_CASE("an observer that was never opened is off and keeps no books") {
  const auto observer = std::make_unique<DelayObserver>();
  CHECK_FALSE(observer->on());
  const Nanoseconds release = monotonic_now() + kMs;
  CHECK(wait_for_release(*observer, 0, release, 50'000).woke_ns >= release);
  observer->after_job(0, release, release + 10 * kMs, 1);
  observer->finish();
  CHECK(observer->statistics().start.raw.count() == 0);
  CHECK(observer->statistics().outliers == 0);
}

}  // namespace sortie::rt::posix
