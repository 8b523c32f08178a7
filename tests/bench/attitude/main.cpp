// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-attitude: the attitude filter's error against its cost, as a table in Markdown. --data DIR
// adds the recorded trials; --gate counts instructions instead and fails where one update costs more than
// half of VQF's, or more than its own bound.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "estimators/attitude.hpp"
#include "tests/bench/attitude/attitude_sweep.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/counted_child.hpp"
#include "tests/bench/vqf_peer.hpp"
#include "tests/estimators/recorded.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {

namespace {

// Mean of one update at 286 Hz, double and float, -O2 for x86-64 by g++ 12; a tenth above what it is.
constexpr double kMostInstructions = 1020;
constexpr std::uint32_t kWarm = 2000;
constexpr std::uint32_t kCounted = 10'000;

AttitudeSet recorded_trial(const std::string& folder, const char* name) {
  AttitudeSet set{name, 1e9 / 3.5e6, {}};
  rt::Nanoseconds now = 0;
  for (const tests::ImuRecord& record : tests::read_imu_file(folder + "/" + name + ".imu")) {
    const float* v = record.value;
    JudgedSample judged;
    judged.sample = {
        now, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}, rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate};
    judged.known = !std::isnan(v[9]);
    judged.judged = judged.known && v[16] >= 0.5f;
    if (judged.known) judged.truth = normalised(rt::Quaternion{v[9], v[10], v[11], v[12]});
    set.samples.push_back(judged);
    now += 3'500'000;
  }
  return set;
}

rt::ImuSample counted_sample(std::uint32_t i) {
  const double x = 0.01 * (i % 37);
  return {static_cast<rt::Nanoseconds>(i) * 3'500'000,
          {x - 0.2, 0.3 - x, 0.5},
          {2 * x, 0.1 - x, 9.8},
          rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate};
}

// The child under callgrind: three marks around the same samples.
int count_child() {
  estimators::Attitude wide{{}};
  estimators::AttitudeFloat narrow{{}};
  VqfPeer peer(0.0035);
  const auto each = [](auto update) {
    for (std::uint32_t i = 0; i < kWarm; ++i) update(counted_sample(i));
    toolchain::mark_count();
    for (std::uint32_t i = kWarm; i < kWarm + kCounted; ++i) update(counted_sample(i));
    toolchain::mark_count();
  };
  toolchain::start_counting();
  each([&](const rt::ImuSample& sample) { static_cast<void>(wide.update(sample)); });
  each([&](const rt::ImuSample& sample) { static_cast<void>(narrow.update(sample)); });
  each([&](const rt::ImuSample& s) {
    peer.update({s.gyr_rad_s[0], s.gyr_rad_s[1], s.gyr_rad_s[2]},
                {s.acc_m_s2[0], s.acc_m_s2[1], s.acc_m_s2[2]});
  });
  return wide.counters().used == kWarm + kCounted && std::isfinite(peer.attitude()[0]) ? 0 : 1;
}

int gate() {
  const Marks marks = count_instructions({toolchain::own_program_path(), "--count-child"});
  if (!marks.why_none.empty()) {
    std::cerr << "skipped: " << marks.why_none << "\n";
    return 77;
  }
  if (marks.instructions.size() != 6)
    throw std::runtime_error("the counted program made another number of marks");
  const auto each = [&](std::size_t i) {
    return static_cast<double>(marks.instructions[2 * i + 1] - marks.instructions[2 * i]) / kCounted;
  };
  std::printf("instructions of one update: double %.1f, float %.1f, VQF %.1f; %.3f and %.3f of VQF's\n",
              each(0), each(1), each(2), each(0) / each(2), each(1) / each(2));
  bool good = true;
  for (const std::size_t i : {0u, 1u}) {
    good = good && each(i) <= kMostInstructions && each(i) <= 0.5 * each(2);
  }
  if (!good) std::cerr << "FAILED: above " << kMostInstructions << " or above half of VQF's\n";
  return good ? 0 : 1;
}

void print(const AttitudeRow& row, double peer_ns) {
  std::printf("| %s | %.0f | %s | %.3f | %.2f | %.0f | %.2f |\n", row.set.c_str(), row.rate_hz,
              row.variant.c_str(), row.inclination_deg, row.heading_deg, row.ns, row.ns / peer_ns);
}

int run(int argc, char** argv) {
  std::string folder;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--count-child") == 0) return count_child();
    if (std::strcmp(argv[i], "--gate") == 0) return gate();
    if (std::strcmp(argv[i], "--data") == 0 && i + 1 < argc)
      folder = argv[++i];
    else
      throw std::invalid_argument(std::string("unknown option ") + argv[i]);
  }
  std::puts(
      "| set | rate Hz | variant | inclination deg | heading deg | ns | of VQF "
      "|\n|---|---:|---|---:|---:|---:|---:|");
  const auto table = [](const AttitudeSet& set) {
    const std::vector<AttitudeRow> rows = measure_attitude(set, 7);
    for (const AttitudeRow& row : rows) print(row, rows.front().ns);
  };
  for (const std::uint32_t rate : {50u, 100u, 200u, 500u, 1000u}) table(simulate_attitude(rate));
  if (folder.empty()) return 0;
  for (const char* name : {"02_undisturbed_slow_rotation_B", "15_undisturbed_fast_translation_A",
                           "25_disturbed_tapping_B", "32_disturbed_attached_magnet_1cm"}) {
    const AttitudeSet set = recorded_trial(folder, name);
    if (set.samples.empty()) continue;
    for (const std::uint32_t every : {1u, 2u, 4u}) table(thinned(set, every));
  }
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-attitude", [&] { return sortie::bench::run(argc, argv); });
}
