// SPDX-License-Identifier: BSD-3-Clause
// Delays whose cause is known, made on purpose, short: the cause is told. The long test counts how often.
#include <catch2/catch.hpp>

#include "tests/rt/cause_confusion.hpp"

namespace sortie::rt::posix::test {
namespace {

// What keeps the rig from running here, or empty.
std::string refusal() {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  return "a sanitizer's own work would be the cause";
#else
  if (usable_cores() < 2) return "this needs two cores";
  if (emulated()) return "an emulated processor has no timing";
  if (const SetupResult fifo = try_fifo(); !fifo.ok) return fifo.reason;
  return "";
#endif
}

// How the delays of a short run were labelled. Where none can be made on purpose it says why, and there are
// none.
ConfusionRow labels_of(Injection injection) {
  if (const std::string why = refusal(); !why.empty()) {
    WARN("skipped: " << why);
    return {};
  }
  SharedResult result;
  CauseRig(injection, 7, 2.0, *result).run();
  REQUIRE(std::string(result->refused).empty());
  const ConfusionRow row = judge(*result);
  if (row.outliers < 10) {
    WARN("skipped: the machine was too busy to inject anything");
    return {};
  }
  return row;
}

// A reading of the kernel's figures that is wrong is wrong for all delays of a kind. What a busy machine adds
// of its own (interrupts, time stolen by its host) takes half of the labels at times, so a third is asked,
// and the share of 95 % is the long test's, on a quiet machine.
bool told(Injection injection, DelayCause cause) {
  for (int run = 0; run < 3; ++run) {
    const ConfusionRow row = labels_of(injection);
    const std::uint32_t right = row.label[static_cast<int>(cause)];
    // No machine is the reason for these two, so they may not stand before what is right.
    const std::uint32_t own = row.label[static_cast<int>(DelayCause::own)];
    const std::uint32_t queued = row.label[static_cast<int>(DelayCause::run_queue)];
    UNSCOPED_INFO(row.injected << " injected, " << row.outliers << " late, " << right << " told right");
    if (right * 3 >= row.outliers && right >= own && right >= queued) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("a hog of higher priority is found in the run queue") {
  CHECK(told(Injection::hog, DelayCause::run_queue));
}

TEST_CASE("work beyond the budget is found to be the program's own") {
  CHECK(told(Injection::own_work, DelayCause::own));
}

TEST_CASE("a flood of signals is found to be interrupts") {
  CHECK(told(Injection::signals, DelayCause::interrupt));
}

TEST_CASE("a pause of the whole process is found to be stolen time") {
  CHECK(told(Injection::pause, DelayCause::stolen));
}

}  // namespace sortie::rt::posix::test
