// SPDX-License-Identifier: BSD-3-Clause
// What is said about a table: verdicts, loads of processors, and the findings with their names.
#include "rt/schedule_report.hpp"

#include <catch2/catch.hpp>

#include "tests/rt/schedule_support.hpp"

using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

const Finding* find(const ScheduleReport& report, FindingKind kind) {
  for (const Finding& finding : report.findings) {
    if (finding.kind == kind) return &finding;
  }
  return nullptr;
}

}  // namespace

TEST_CASE("a table with room is schedulable and has nothing to complain of") {
  const ScheduleReport report = analyse(table_of({declared(1, 150, 0, 0), declared(100, 50'000, 0, 0)}));
  CHECK(report.schedulable);
  CHECK(report.harmonic);
  CHECK(report.hyperperiod_ticks == 100);
  CHECK(report.findings.empty());
  REQUIRE(report.groups.size() == 2);
  CHECK(report.groups[0].priority == 0);
  CHECK(report.groups[1].priority == 1);
  CHECK(report.groups[0].worst().ns == 150'000);
  // 50 ms of work in what 0.85 ms of each tick leave: 58 ticks and the rest behind the control job of the
  // next.
  CHECK(report.groups[1].worst().ns == 58'850'000);
  REQUIRE(report.cores.size() == 1);
  CHECK(report.cores[0].core == 0);
  CHECK(report.cores[0].utilisation[0] == Approx(0.65));
  CHECK(report.cores[0].tick.waiting_ns == 50'150'000);
}

TEST_CASE("a response beyond the deadline is a finding with the group's number") {
  const ScheduleReport report = analyse(table_of({declared(1, 500), declared(10, 2000, 0, -1, 3)}));
  CHECK_FALSE(report.schedulable);
  CHECK(report.groups[0].fits);
  CHECK_FALSE(report.groups[1].fits);
  CHECK(report.groups[1].worst().ns == 4'000'000);
  const Finding* late = find(report, FindingKind::late);
  REQUIRE(late != nullptr);
  CHECK(late->a == 1);
  CHECK(find(report, FindingKind::overload) == nullptr);
  CHECK(find(report, FindingKind::one_processor) != nullptr);
}

TEST_CASE("a phase can make a table fit that does not when all is released at once") {
  // Both have a deadline of one tick and 0.6 ms of work: never together.
  ScheduleTable table = table_of({declared(2, 600, 0, 0, 1), declared(2, 600, 0, 0, 1)});
  CHECK_FALSE(analyse(table).schedulable);
  choose_phases(table);
  const ScheduleReport report = analyse(table);
  CHECK(report.schedulable);
  CHECK(report.groups[1].with_phases.ns == 600'000);
  CHECK(report.groups[1].any_phase.ns == 1'200'000);
}

TEST_CASE("an overloaded and a nearly full processor are named") {
  const ScheduleReport report =
      analyse(table_of({declared(10, 9'500, 0, 3), declared(10, 6'000, 0, 1), declared(20, 9'000, 0, 1)}));
  CHECK_FALSE(report.schedulable);
  REQUIRE(report.cores.size() == 2);
  CHECK(report.cores[0].core == 1);
  CHECK(report.cores[0].utilisation[0] == Approx(1.05));
  CHECK(report.cores[1].core == 3);
  CHECK(report.cores[1].utilisation[0] == Approx(0.95));
  const Finding* overload = find(report, FindingKind::overload);
  REQUIRE(overload != nullptr);
  CHECK(overload->core == 1);
  const Finding* full = find(report, FindingKind::nearly_full);
  REQUIRE(full != nullptr);
  CHECK(full->core == 3);
  const Finding* late = find(report, FindingKind::late);
  REQUIRE(late != nullptr);
  CHECK(late->a == 2);
  CHECK_FALSE(report.groups[2].worst().known);
}

TEST_CASE("periods that do not divide each other and patterns without end are said so") {
  const ScheduleReport odd = analyse(table_of({declared(4, 100), declared(6, 100)}));
  CHECK_FALSE(odd.harmonic);
  const Finding* pair = find(odd, FindingKind::not_harmonic);
  REQUIRE(pair != nullptr);
  CHECK(pair->a == 0);
  CHECK(pair->b == 1);
  CHECK(find(odd, FindingKind::long_hyperperiod) == nullptr);
  // 999,983 and 1,000,003 are primes: exact responses are out of reach, those for any phase are not.
  const ScheduleReport endless =
      analyse(table_of({declared(999'983, 100), declared(1'000'003, 100), declared(1, 9)}));
  CHECK(endless.schedulable);
  CHECK(find(endless, FindingKind::long_hyperperiod) != nullptr);
  CHECK_FALSE(endless.groups[1].with_phases.known);
  CHECK(endless.groups[1].worst().known);
}
