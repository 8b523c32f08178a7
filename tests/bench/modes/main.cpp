// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-modes: vertical error of the track odometry over obstacles of the plant, the standard method
// beside ours, with perfect and with disturbed sensors. `--train` makes the decision tree instead.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include "tests/bench/modes/course_run.hpp"
#include "tests/bench/modes/training.hpp"

namespace sortie::bench {
namespace {

constexpr double kSpeeds_m_s[] = {0.05, 0.15, 0.5};
constexpr double kDegree = 3.14159265358979323846 / 180.0;

struct Sums {
  double way_m{}, standard{}, ours{}, floor{}, pivot{};
  void add(const CourseResult& r) {
    way_m += r.way_m;
    standard += r.standard;
    ours += r.ours;
    floor += r.floor;
    pivot += r.pivot;
  }
  double mm(double sum) const { return 1e3 * std::sqrt(sum / way_m); }
};

std::vector<Disturbance> disturbances() {
  Disturbance noisy;
  noisy.name = "disturbed";
  noisy.slip = 0.02;
  noisy.attitude_bias_rad = 0.2 * kDegree;
  noisy.attitude_walk_rad = 5e-5;
  noisy.force_noise_m_s2 = 0.04;  // 4e-3 per root Hz at 100 Hz
  std::vector<Disturbance> all{{}};
  all.push_back({});
  all.back().name = "perfect, no accelerometer";
  all.back().accelerometer = false;
  all.push_back(noisy);
  all.push_back(noisy);
  all.back().name = "disturbed, accelerometer off by 0.02 m/s^2";
  all.back().force_bias_m_s2 = 0.02;
  all.push_back(noisy);
  all.back().name = "disturbed, no accelerometer";
  all.back().accelerometer = false;
  for (const double sign : {-1.0, 1.0}) {
    all.push_back(noisy);
    all.back().name = sign < 0 ? "disturbed, length -3 %, radius -10 %, centre of mass -2 cm"
                               : "disturbed, length +3 %, radius +10 %, centre of mass +2 cm";
    all.back().length = 1.0 + sign * 0.03;
    all.back().radius = 1.0 + sign * 0.10;
    all.back().com_m = sign * 0.02;
  }
  return all;
}

struct Table {
  std::map<std::string, Sums> rows;
  double mode_m[4]{}, hit_m[4]{}, time_s{}, false_s{};
  double worse_mm{-1e9};
};

void print(const Disturbance& wrong, const Table& table) {
  std::printf("\n%s\n%-14s %9s %9s %8s %9s %9s\n", wrong.name, "", "standard", "ours", "factor", "floor",
              "pivot");
  for (const auto& [name, s] : table.rows)
    std::printf("%-14s %6.1f mm %6.1f mm %8.2f %6.1f mm %6.1f mm\n", name.c_str(), s.mm(s.standard),
                s.mm(s.ours), s.mm(s.standard) / std::max(1e-3, s.mm(s.ours)), s.mm(s.floor), s.mm(s.pivot));
  const char* names[] = {"planar", "low rear", "edge pivot", "low front"};
  for (int i = 0; i < 4; ++i)
    if (table.mode_m[i] > 0)
      std::printf("%-14s named over %.1f %% of %.1f m\n", names[i], 100 * table.hit_m[i] / table.mode_m[i],
                  table.mode_m[i]);
  std::printf(
      "flats and slopes: another mode over %.2f %% of the time, rms above the standard's by %.2f mm at "
      "most\n",
      table.time_s > 0 ? 100 * table.false_s / table.time_s : 0.0, table.worse_mm);
}

void measure(const std::vector<std::uint64_t>& seeds, bool each, const std::string& paths) {
  const std::vector<Disturbance> all = disturbances();
  std::vector<Table> tables(all.size());
  std::ofstream csv;
  if (!paths.empty()) {
    csv.open(paths);
    csv << "scene,speed_m_s,travel_m,truth_m,standard_m,ours_m,mode\n";
  }
  for (const std::uint64_t seed : seeds) {
    for (const CourseScene& scene : course_scenes(seed)) {
      for (const hil::ContactMode mode : {hil::ContactMode::csm, hil::ContactMode::belt}) {
        for (const double speed : kSpeeds_m_s) {
          const std::vector<CourseSample> drive = drive_course(scene, speed, mode);
          char label[64];
          std::snprintf(label, sizeof label, "at %.2f m/s", speed);
          for (std::size_t i = 0; i < all.size(); ++i) {
            std::vector<CoursePoint> path;
            const bool keep = csv.is_open() && i == 0 && mode == hil::ContactMode::csm;
            const CourseResult r = run_course(scene, drive, all[i], seed, keep ? &path : nullptr);
            if (!r.crossed) {
              if (i == 0) std::printf("left out, stuck: %s at %.2f m/s\n", scene.name.c_str(), speed);
              break;
            }
            Table& t = tables[i];
            for (const std::string& row : {scene.family, std::string(label), std::string("~ all")})
              t.rows[row].add(r);
            t.rows[mode == hil::ContactMode::csm ? "in csm" : "in belt"].add(r);
            for (std::size_t k = 0; k < 4; ++k) {
              t.mode_m[k] += r.mode_m[k];
              t.hit_m[k] += r.hit_m[k];
            }
            t.time_s += r.time_s;
            t.false_s += r.false_s;
            if (scene.planar)
              t.worse_mm =
                  std::max(t.worse_mm, 1e3 * (std::sqrt(r.ours / r.way_m) - std::sqrt(r.standard / r.way_m)));
            if (each && i == 0)
              std::printf("%-36s %s %.2f m/s  standard %6.1f mm  ours %6.1f mm\n", scene.name.c_str(),
                          mode == hil::ContactMode::csm ? "csm " : "belt", speed,
                          1e3 * std::sqrt(r.standard / r.way_m), 1e3 * std::sqrt(r.ours / r.way_m));
            for (const CoursePoint& p : path)
              csv << scene.name << ',' << speed << ',' << p.travel_m << ',' << p.truth_m << ','
                  << p.standard_m << ',' << p.ours_m << ',' << p.mode << '\n';
          }
        }
      }
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) print(all[i], tables[i]);
}

int run(int argc, char** argv) {
  bool each = false;
  bool training = false;
  std::string paths;
  std::vector<std::uint64_t> seeds;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--each") {
      each = true;
    } else if (word == "--train") {
      training = true;
    } else if (word == "--paths" && i + 1 < argc) {
      paths = argv[++i];
    } else if (!word.empty() && word.find_first_not_of("0123456789") == std::string::npos) {
      seeds.push_back(std::stoull(word));
    } else {
      std::fprintf(stderr, "sortie-bench-modes [--each] [--paths FILE] [--train] SEED...\n");
      return 2;
    }
  }
  if (seeds.empty())
    seeds = training ? std::vector<std::uint64_t>{1, 2, 3, 5, 6, 7, 8, 9, 10, 12}
                     : std::vector<std::uint64_t>{3001, 3002};
  std::fprintf(stderr, "seeds");
  for (const std::uint64_t seed : seeds) std::fprintf(stderr, " %llu", static_cast<unsigned long long>(seed));
  std::fprintf(stderr, "\n");
  if (training) {
    train_modes(seeds);
  } else {
    measure(seeds, each, paths);
  }
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  try {
    return sortie::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sortie-bench-modes: %s\n", error.what());
    return 1;
  }
}
