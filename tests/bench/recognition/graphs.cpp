// SPDX-License-Identifier: BSD-3-Clause
// Any graph: how large a set a search of so many units finds, where a set is planted.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/bench/recognition/owned_sets.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/report/picture.hpp"

namespace sortie::bench {
namespace {
using mapping::BitGraph;

constexpr std::uint32_t kVertices = 2048;
constexpr std::uint32_t kPlanted = 12;
constexpr double kMost_ms = 20.0;

struct DenseGraph {
  std::vector<BitGraph::Word> bits, members;
  BitGraph graph;

  DenseGraph(double density, std::uint64_t seed)
      : bits(BitGraph::matrix_words(kVertices)),
        members(BitGraph::words_of(kVertices)),
        graph(kVertices, bits) {
    std::mt19937_64 engine(seed);
    const auto below = static_cast<std::uint64_t>(std::ldexp(density, 53));
    BitGraph::fill(members, kVertices);
    for (std::uint32_t a = 0; a < kVertices; ++a) {
      for (std::uint32_t b = 0; b < a; ++b) {
        if (engine() >> 11 < below) graph.connect(a, b);
      }
    }
    std::vector<std::uint32_t> planted;
    while (planted.size() < kPlanted) {
      const auto v = static_cast<std::uint32_t>(engine() % kVertices);
      bool is_new = true;
      for (const std::uint32_t other : planted) is_new = is_new && other != v;
      if (!is_new) continue;
      for (const std::uint32_t other : planted) graph.connect(v, other);
      planted.push_back(v);
    }
  }
};

struct OwnedSearch {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::ConsistentSet set;

  OwnedSearch() : memory(3'000'000), arena(memory), set({kVertices, kVertices, 128}, arena) {
    if (arena.refused() != 0) throw std::runtime_error("recognition: no room for graphs");
  }
};
}  // namespace

void measure_recognition_graphs(const RecognitionSettings& settings, Report& report) {
  const int cases = settings.cases_or(100);
  OwnedSearch owned;
  Json rows = Json::array();
  Picture picture{"bench-recognition-graphs",
                  "graphs",
                  "Sets found in graphs of 2,048 vertices",
                  "ms (median)",
                  "vertices of the set (mean)",
                  true,
                  false,
                  false,
                  {}};
  for (const double density : {0.02, 0.1, 0.5}) {
    Curve curve{"density " + std::to_string(density).substr(0, 4), {}, {}, {}, "", -1};
    for (const std::uint64_t units : {100'000u, 300'000u, 1'000'000u, 3'000'000u, 6'000'000u, 20'000'000u}) {
      Rounds ms, size;
      int planted = 0, proved = 0;
      std::uint64_t over = 0;
      const int tried = units > 6'000'000 ? cases / 5 + 1 : cases;
      for (int i = 0; i < tried; ++i) {
        const DenseGraph dense(density, settings.seed + static_cast<std::uint64_t>(i));
        owned.set.begin(dense.graph, dense.members, 4);
        const double begin = set_cpu_ms();
        std::uint64_t left = units;
        (void)owned.set.run(left);
        ms.add(set_cpu_ms() - begin);
        over += left > units ? 1u : 0u;
        const auto found = static_cast<double>(owned.set.found().size());
        size.add(found);
        planted += found >= kPlanted ? 1 : 0;
        proved += owned.set.proved() ? 1 : 0;
      }
      double mean = 0.0;
      for (const double v : size.values()) mean += v / tried;
      rows.push_back({density, units, tried, std::round(100 * ms.median()) / 100,
                      std::round(100 * ms.high()) / 100, std::round(10 * mean) / 10, size.low(), planted,
                      proved});
      curve.x.push_back(ms.median());
      curve.y.push_back(mean);
      if (density == 0.5 && units == 3'000'000) {
        Figure figure;
        figure.group = "graphs";
        figure.what = "12 of 2,048 found, density 0.5, 3 million units";
        figure.unit = "of " + std::to_string(tried);
        figure.n = static_cast<std::uint64_t>(tried);
        figure.ours = spread(planted);
        set_goal(figure, "95 % in 20 ms",
                 planted >= 0.95 * tried && ms.quantile(0.95) <= kMost_ms && over == 0);
        report.add(figure);
      }
    }
    picture.curves.push_back(curve);
  }
  report.add_table("graphs",
                   {"density", "units", "n", "ms", "max", "vertices found", "fewest", "12 or more", "proved"},
                   rows);
  add_picture(report, picture);
  report.note(
      "graphs",
      "At a density of 0.5 a graph of 2,048 vertices has sets of 14 and more by chance: what is found "
      "there need not be the one that was planted.");
}

}  // namespace sortie::bench
