// SPDX-License-Identifier: BSD-3-Clause
// The decision about causes, over made-up numbers: each kind of evidence leads to its cause, a split adds up
// to the last nanosecond, and where there is no evidence nothing is claimed.
#include "rt/posix/delay_cause.hpp"

#include <catch2/catch.hpp>
#include <iterator>
#include <memory>
#include <numeric>
#include <random>

#include "rt/posix/delay_statistics.hpp"
#include "tests/rt/burn.hpp"

namespace sortie::rt::posix {
namespace {

using test::kMs;

DelaySample late_by(Nanoseconds late) {
  DelaySample sample;
  sample.late_ns = late;
  return sample;
}

}  // namespace

TEST_CASE("a delay without evidence is unknown") {
  const DelaySplit split = split_delay(late_by(3 * kMs));
  CHECK(split[DelayCause::unknown] == 3 * kMs);
  CHECK(split.total() == 3 * kMs);
  CHECK(split.main_cause() == DelayCause::unknown);
  CHECK(split_delay(late_by(0)).total() == 0);
}

TEST_CASE("growth of the run-queue delay is the run queue's") {
  DelaySample sample = late_by(kMs);
  sample.run_queue_ns = 900'000;
  const DelaySplit split = split_delay(sample);
  CHECK(split[DelayCause::run_queue] == 900'000);
  CHECK(split[DelayCause::unknown] == 100'000);
}

TEST_CASE("a thread that was ready waited for interrupts as far as there were more than usual") {
  DelaySample sample;
  sample.late_ns = 3'000'000;
  sample.run_queue_ns = 3'000'000;
  sample.interrupts = 160;
  DelaySplit split = split_delay(sample);
  CHECK(split[DelayCause::interrupt] == 160 * kInterruptCostNs);
  CHECK(split[DelayCause::run_queue] == 3'000'000 - 160 * kInterruptCostNs);
  // What the same interrupts took from the job is not taken a second time.
  sample.late_ns = 5'000'000;
  sample.charged_ns = 2'000'000;
  split = split_delay(sample);
  CHECK(split[DelayCause::interrupt] == 160 * kInterruptCostNs);
  CHECK(split[DelayCause::own] == 0);
  CHECK(split[DelayCause::run_queue] == 5'000'000 - 160 * kInterruptCostNs);
  sample.interrupts = 0;
  CHECK(split_delay(sample)[DelayCause::run_queue] == 3'000'000);
}

TEST_CASE("time that nobody was charged for is stolen unless the thread itself left the core") {
  DelaySample sample = late_by(kMs);
  sample.uncharged_ns = kMs;
  CHECK(split_delay(sample)[DelayCause::stolen] == kMs);
  sample.switched = true;  // it blocked
  CHECK(split_delay(sample)[DelayCause::own] == kMs);
  sample.pause_ns = 700'000;  // or it was stopped together with everyone else
  CHECK(split_delay(sample)[DelayCause::stolen] == 700'000);
  CHECK(split_delay(sample)[DelayCause::own] == 300'000);
}

TEST_CASE("a late timer is stolen with a pause or on a guest and else unknown") {
  DelaySample sample = late_by(kMs);
  sample.timer_late_ns = kMs;
  CHECK(split_delay(sample).main_cause() == DelayCause::unknown);
  sample.guest_timer = true;
  CHECK(split_delay(sample)[DelayCause::stolen] == kMs);
  sample.guest_timer = false;
  sample.pause_ns = 2 * kMs;
  CHECK(split_delay(sample)[DelayCause::stolen] == kMs);
  sample.pause_ns = 0;
  sample.interrupts = 50;
  CHECK(split_delay(sample)[DelayCause::interrupt] == 50 * kInterruptCostNs);
  CHECK(split_delay(sample)[DelayCause::unknown] == kMs - 50 * kInterruptCostNs);
}

TEST_CASE("CPU time charged to a waiting thread is an interrupt") {
  DelaySample sample = late_by(kMs);
  sample.disturbed_ns = kMs;
  CHECK(split_delay(sample)[DelayCause::interrupt] == kMs);
  sample.pause_ns = kMs;  // with a steal clock a pause would not have been charged
  CHECK(split_delay(sample)[DelayCause::interrupt] == kMs);
  sample.steal_charged = true;
  CHECK(split_delay(sample)[DelayCause::stolen] == kMs);
}

TEST_CASE("CPU time of a job beyond what is declared is its own work and interrupts can take it over") {
  DelaySample sample = late_by(kMs);
  sample.charged_ns = 3 * kMs;
  sample.allowed_ns = 2 * kMs;
  CHECK(split_delay(sample)[DelayCause::own] == kMs);
  sample.interrupts = 1'000;
  CHECK(split_delay(sample)[DelayCause::interrupt] == kMs);
  sample.interrupts = 0;
  sample.steal_charged = true;
  sample.pause_ns = 900'000;
  CHECK(split_delay(sample)[DelayCause::stolen] == 900'000);
  CHECK(split_delay(sample)[DelayCause::own] == 100'000);
}

TEST_CASE("one pause is not counted twice") {
  DelaySample sample = late_by(4 * kMs);
  sample.timer_late_ns = 2 * kMs;
  sample.uncharged_ns = 2 * kMs;
  sample.switched = true;
  sample.pause_ns = 2 * kMs;
  const DelaySplit split = split_delay(sample);
  CHECK(split[DelayCause::stolen] == 2 * kMs);
  CHECK(split[DelayCause::unknown] == 2 * kMs);
}

TEST_CASE("lateness that a job takes over from the one before keeps its cause") {
  DelaySample sample = late_by(500'000);
  sample.inherited[DelayCause::stolen] = 900'000;
  sample.charged_ns = 600'000;  // a job of 0.6 ms in a period of 1 ms works 0.4 ms of the lateness off
  sample.allowed_ns = kMs;
  CHECK(split_delay(sample)[DelayCause::stolen] == 500'000);
  sample.charged_ns = 1'100'000;  // one of 1.1 ms adds to it
  const DelaySplit split = split_delay(sample);
  CHECK(split[DelayCause::stolen] == 450'000);
  CHECK(split[DelayCause::own] == 50'000);
}

TEST_CASE("any numbers at all give parts that are not negative and add up exactly") {
  const std::uint32_t seed = GENERATE(1u, 2u, 3u);
  INFO("seed " << seed);
  std::minstd_rand random(seed);
  const auto any = [&random]() -> Nanoseconds {
    switch (random() % 6) {
      case 0:
        return 0;
      case 1:
        return -static_cast<Nanoseconds>(random() % 1'000'000);
      case 2:
        return static_cast<Nanoseconds>(random()) * 3'600'000;  // up to three months
      default:
        return static_cast<Nanoseconds>(random() % 5'000'000);
    }
  };
  for (int i = 0; i < 20'000; ++i) {
    DelaySample sample;
    sample.late_ns = any();
    sample.run_queue_ns = any();
    sample.timer_late_ns = any();
    sample.uncharged_ns = any();
    sample.charged_ns = any();
    sample.allowed_ns = any();
    sample.disturbed_ns = any();
    sample.pause_ns = any();
    sample.interrupts = static_cast<std::uint32_t>(random());
    sample.switched = random() % 2 == 0;
    sample.steal_charged = random() % 2 == 0;
    sample.guest_timer = random() % 2 == 0;
    for (Nanoseconds& part : sample.inherited.ns) part = any() > 0 ? any() : 0;
    for (Nanoseconds& part : sample.inherited.ns) part = part < 0 ? 0 : part;
    const DelaySplit split = split_delay(sample);
    if (split.total() != (sample.late_ns > 0 ? sample.late_ns : 0)) FAIL("case " << i << " does not add up");
    for (const Nanoseconds part : split.ns) {
      if (part < 0) FAIL("case " << i << " has a negative part");
    }
  }
}

TEST_CASE("a split in proportion is exact to a nanosecond in each part but the largest") {
  DelaySplit split;
  split[DelayCause::own] = 1;
  split[DelayCause::run_queue] = 1;
  split[DelayCause::stolen] = 1;
  const DelaySplit fitted = split.fitted_to(2);
  CHECK(fitted.total() == 2);
  split[DelayCause::own] = 300;
  split[DelayCause::run_queue] = 200;
  split[DelayCause::stolen] = 100;
  CHECK(split.fitted_to(300)[DelayCause::own] == 150);
  CHECK(split.fitted_to(300)[DelayCause::run_queue] == 100);
  CHECK(split.fitted_to(300)[DelayCause::stolen] == 50);
  CHECK(split.fitted_to(700)[DelayCause::unknown] == 100);
}

TEST_CASE("clean statistics leave out what lies outside the program and raw ones nothing") {
  const auto statistics = std::make_unique<DelayStatistics>();
  DelayTable& start = statistics->start;
  const auto late = [&](DelayCause cause, std::uint64_t ns) {
    start.raw.record(ns);
    DelayOutlier outlier;
    outlier.kind = DelayKind::start;
    outlier.late_ns = static_cast<Nanoseconds>(ns);
    outlier.split[cause] = outlier.late_ns;
    statistics->add(outlier, ns);
  };
  start.raw.record(40);
  start.add_clean(40);
  late(DelayCause::stolen, 17'000'000);
  late(DelayCause::run_queue, 300'000);
  late(DelayCause::interrupt, 150'000);
  late(DelayCause::own, 120'000);
  CHECK(start.clean_max_ns == 120'000);
  late(DelayCause::unknown, 130'000);
  CHECK(start.raw.count() == 6);
  CHECK(start.raw.max() == 17'000'000);
  CHECK(start.clean_count == 3);
  CHECK(start.clean_max_ns == 130'000);
  CHECK(start.outliers == 5);
  CHECK(std::accumulate(std::begin(start.total_ns), std::end(start.total_ns), Nanoseconds{0}) == 17'700'000);
  CHECK(start.count[static_cast<int>(DelayCause::stolen)] == 1);
  CHECK(start.total_ns[static_cast<int>(DelayCause::stolen)] == 17'000'000);
  CHECK(statistics->execution.outliers == 0);
  for (int i = 0; i < 100; ++i) late(DelayCause::own, 200'000 + static_cast<std::uint64_t>(i));
  CHECK(statistics->outliers == 105);
  CHECK(statistics->last[104 % DelayStatistics::kLast].late_ns == 200'099);
}

}  // namespace sortie::rt::posix
