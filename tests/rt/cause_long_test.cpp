// SPDX-License-Identifier: BSD-3-Clause
// The confusion table of causes: delays made on purpose against the label that they got. Printed as markdown;
// docs/results/causes.md holds one run.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "tests/rt/cause_confusion.hpp"

namespace sortie::rt::posix::test {
namespace {

// Seconds for each injection; 20 give some 700 delays a row.
double seconds() {
  const char* text = std::getenv("SORTIE_CAUSE_SECONDS");
  const double asked = text == nullptr ? 0.0 : std::atof(text);
  return asked > 0.0 ? asked : 20.0;
}

double milliseconds(Nanoseconds ns) { return static_cast<double>(ns) / 1e6; }

void print_row(const char* name, std::uint32_t injected, std::uint32_t delays,
               const std::uint32_t (&label)[kDelayCauses], const char* right, Nanoseconds total,
               Nanoseconds unknown) {
  std::printf("| %s | %u | %u |", name, injected, delays);
  for (const std::uint32_t count : label) std::printf(" %u |", count);
  const double share = total > 0 ? 100.0 * static_cast<double>(unknown) / static_cast<double>(total) : 0.0;
  std::printf(" %s | %.1f | %.2f %% |\n", right, milliseconds(total), share);
}

}  // namespace

TEST_CASE("injected causes are told right in 95 of 100 delays and hardly any lateness stays unknown") {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  WARN("skipped: a sanitizer's own work would be the cause");
  return;
#endif
  if (const SetupResult fifo = try_fifo(); usable_cores() < 2 || emulated() || !fifo.ok) {
    WARN("skipped: " << (fifo.ok ? "this needs two real cores" : fifo.reason));
    return;
  }
  std::printf(
      "| injected | n | delays above 100 us | own work | interrupt | run queue | stolen | unknown | right | "
      "time [ms] | of it unknown |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
  ConfusionRow others;
  for (const Injection injection :
       {Injection::hog, Injection::own_work, Injection::signals, Injection::queued_signals, Injection::timers,
        Injection::pause, Injection::none}) {
    SharedResult result;
    CauseRig(injection, 20'26u, seconds(), *result).run();
    REQUIRE(std::string(result->refused).empty());
    const ConfusionRow row = judge(*result);
    others.other_outliers += row.other_outliers;
    for (int i = 0; i < kDelayCauses; ++i) others.other_label[i] += row.other_label[i];
    others.other_total_ns += row.other_total_ns;
    others.other_unknown_ns += row.other_unknown_ns;
    if (injection == Injection::none) break;
    const std::uint32_t right = row.label[static_cast<int>(truth_of(injection))];
    const double share = row.outliers == 0 ? 0.0 : 100.0 * right / row.outliers;
    char text[16];
    std::snprintf(text, sizeof(text), "%.1f %%", share);
    print_row(to_string(injection), row.injected, row.outliers, row.label, text, row.total_ns,
              row.unknown_ns);
    INFO(to_string(injection));
    CHECK(row.outliers >= 20);
    CHECK(share >= 95.0);
    CHECK(row.unknown_ns * 20 <= row.total_ns);
  }
  print_row("nothing: the machine's own", 0, others.other_outliers, others.other_label, "",
            others.other_total_ns, others.other_unknown_ns);
  CHECK(others.other_unknown_ns * 20 <= others.other_total_ns);
}

}  // namespace sortie::rt::posix::test
