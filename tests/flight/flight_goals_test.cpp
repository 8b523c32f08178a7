// SPDX-License-Identifier: BSD-3-Clause
// What the multirotor promises, flown: the parts of `sortie bench uav` that have goals and no clock, each
// with one seed. A goal that is missed names itself.
#include <catch2/catch.hpp>

#include "tests/bench/uav/uav_parts.hpp"

namespace {

using FlightPart = void (*)(const sortie::bench::UavSettings&, sortie::bench::Report&);

// Flies a part, checks all goals of its figures, and gives how many there were.
int check_flight_goals(FlightPart part) {
  sortie::bench::UavSettings settings;
  settings.seeds = 1;
  settings.fleet = 5;
  settings.brief = true;
  sortie::bench::Report report;
  for (const char* list : {"figures", "tables", "skipped", "notes", "pictures"})
    report.root()[list] = sortie::bench::Json::array();
  part(settings, report);
  int judged = 0;
  for (const sortie::bench::Json& figure : report.root()["figures"]) {
    if (!figure.contains("met") || !figure["met"].is_boolean()) continue;
    ++judged;
    INFO(figure.dump());
    CHECK(figure["met"].get<bool>());
  }
  CHECK(report.root()["skipped"].empty());
  return judged;
}

}  // namespace

TEST_CASE("Flights beside Lee's: fifteen times better, three times with an integrator, ten times late",
          "[heavy]") {
  CHECK(check_flight_goals(sortie::bench::measure_uav_peers) >= 7);
}

TEST_CASE("One stress at a time, goals, lost rotors and drawn vehicles keep their limits", "[heavy]") {
  CHECK(check_flight_goals(sortie::bench::measure_uav_stress) >= 26);
}

TEST_CASE("Flights on estimates, without fixes and with late commands keep their limits", "[heavy]") {
  CHECK(check_flight_goals(sortie::bench::measure_uav_estimated) >= 4);
}

TEST_CASE("A planned way is flown in gusts on estimates and nothing is touched", "[heavy]") {
  CHECK(check_flight_goals(sortie::bench::measure_uav_pictures) >= 3);
}
