// SPDX-License-Identifier: BSD-3-Clause
// The model check of the drives' group, with both protocols: no order of deeds drives a wheel against the
// promise of docs/safety.md.
#include <catch2/catch.hpp>

#include "tests/hil/drives_model.hpp"

using namespace sortie;
using namespace sortie::hil::test;

namespace {

template <class Kind>
SearchResult searched(int depth, int dwell_ms, bool merges, rt::Nanoseconds rearm_ns = 0,
                      bool flippers = false) {
  DrivesModel<Kind> model = asked_model<Kind>(flippers, rearm_ns);
  model.pass(600);
  REQUIRE(model.found == "");
  REQUIRE(model.world.runtime().running());
  REQUIRE(model.world.driven(0));
  return DrivesSearch<Kind>(depth, dwell_ms, merges)(model);
}

std::string told(const SearchResult& result) {
  std::string text = result.found + " (deeds:";
  for (const int deed : result.way) text += " " + std::to_string(deed);
  return text + ")";
}

}  // namespace

TEMPLATE_TEST_CASE("drives model: every order of four deeds keeps the promise", "[model]", CanopenKind,
                   OdriveKind) {
  for (const int dwell_ms : {9, 100}) {
    CAPTURE(dwell_ms);
    const SearchResult result = searched<TestType>(4, dwell_ms, false);
    CAPTURE(told(result));
    CHECK(result.found.empty());
    CHECK(result.states == 1 + 8 + 64 + 512 + 4096);
    CHECK(result.running > 10);  // else the search saw nothing but drives at rest
  }
}

TEMPLATE_TEST_CASE("drives model: and of five where what is alike is gone on from once, also with re-arming",
                   "[model]", CanopenKind, OdriveKind) {
  for (const int rearm_ms : {0, 300}) {
    CAPTURE(rearm_ms);
    const SearchResult result = searched<TestType>(5, 120, true, rearm_ms * rt::kNanosecondsPerMillisecond);
    CAPTURE(told(result));
    CHECK(result.found.empty());
    CHECK(result.states > 1000);
  }
}

TEMPLATE_TEST_CASE(
    "drives model: flippers have a source of their own, and the tracks' requests are not theirs", "[model]",
    CanopenKind, OdriveKind) {
  for (const int rearm_ms : {0, 300}) {
    CAPTURE(rearm_ms);
    const SearchResult result =
        searched<TestType>(3, 120, false, rearm_ms * rt::kNanosecondsPerMillisecond, true);
    CAPTURE(told(result));
    CHECK(result.found.empty());
    CHECK(result.states == 1 + 10 + 100 + 1000);
    CHECK(result.running > 10);
  }
}
