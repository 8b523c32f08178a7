// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/set_peers.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace sortie::bench {
namespace {
using mapping::PlaceCm;
using mapping::SweptPair;

double distance_m(const PlaceCm& a, const PlaceCm& b) {
  const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
  return 0.01 * std::sqrt(x * x + y * y + z * z);
}

/// Both halves of a symmetric matrix of scores without its diagonal, row by row.
struct Scores {
  std::vector<std::uint32_t> begin{0};
  std::vector<std::uint32_t> other;
  std::vector<double> score;
  std::size_t size() const { return begin.size() - 1; }
};

Scores score_pairs(const std::vector<SweptPair>& pairs, double eps_m) {
  const std::size_t n = pairs.size();
  const double sigma = 0.25 * eps_m;
  std::vector<std::vector<std::pair<std::uint32_t, double>>> rows(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = i + 1; k < n; ++k) {
      const SweptPair &a = pairs[i], &b = pairs[k];
      if (a.pair.segment == b.pair.segment || a.pair.target == b.pair.target) continue;
      const double c = std::fabs(distance_m(a.segment, b.segment) - distance_m(a.target, b.target));
      if (c >= eps_m) continue;
      const double score = std::exp(-0.5 * c * c / (sigma * sigma));
      rows[i].emplace_back(k, score);
      rows[k].emplace_back(i, score);
    }
  }
  Scores scores;
  for (const auto& row : rows) {
    for (const auto& [other, score] : row) {
      scores.other.push_back(other);
      scores.score.push_back(score);
    }
    scores.begin.push_back(static_cast<std::uint32_t>(scores.other.size()));
  }
  return scores;
}

using Vector = std::vector<double>;

/// M u and C u, with ones on both diagonals; C has a one wherever M has a score.
void products(const Scores& s, const Vector& u, Vector& scored, Vector& counted) {
  for (std::size_t i = 0; i < s.size(); ++i) {
    double score = u[i], count = u[i];
    for (std::uint32_t at = s.begin[i]; at < s.begin[i + 1]; ++at) {
      const double other = u[s.other[at]];
      score += s.score[at] * other;
      count += other;
    }
    scored[i] = score;
    counted[i] = count;
  }
}

double normalise(Vector& u) {
  const double length = std::sqrt(std::inner_product(u.begin(), u.end(), u.begin(), 0.0));
  for (double& v : u) v /= length;
  return length;
}
}  // namespace

Chosen dense_cluster(const std::vector<SweptPair>& pairs, double eps_m, std::uint64_t seed) {
  constexpr double kTiny = 1e-9, kMoved = 1e-8, kRaised = 1e-9, kBack = 0.25;
  const Scores scores = score_pairs(pairs, eps_m);
  const std::size_t n = scores.size();
  Vector u(n), next(n), scored(n), counted(n), slope(n);
  std::mt19937_64 engine(seed);
  for (double& v : u) v = std::ldexp(static_cast<double>(engine() >> 11), -53);
  products(scores, u, scored, counted);
  u = scored;
  normalise(u);
  /// What a unit of contradiction has to cost so that some vertex no longer gains; none contradicts: 0.
  const auto price = [&](bool& any) {
    products(scores, u, scored, counted);
    const double sum = std::accumulate(u.begin(), u.end(), 0.0);
    double least = 0.0;
    any = false;
    for (std::size_t i = 0; i < n; ++i) {
      const double against = sum - counted[i];
      if (!(against > kTiny && u[i] > kTiny)) continue;
      const double cost = std::fabs(scored[i] / against);
      least = any ? std::min(least, cost) : cost;
      any = true;
    }
    return least;
  };
  bool contradicted = false;
  double d = price(contradicted), value = 0.0;
  const auto slope_at = [&](const Vector& at) {
    products(scores, at, scored, counted);
    const double sum = std::accumulate(at.begin(), at.end(), 0.0);
    for (std::size_t i = 0; i < n; ++i) slope[i] = scored[i] - d * (sum - counted[i]);
    return std::inner_product(at.begin(), at.end(), slope.begin(), 0.0);
  };
  for (int outer = 0; outer < 1000; ++outer) {
    value = slope_at(u);
    for (int inner = 0; inner < 200; ++inner) {
      const Vector direction = slope;
      double step = 1.0, raised = 0.0, reached = value;
      for (int back = 0; back < 99; ++back) {
        for (std::size_t i = 0; i < n; ++i) next[i] = std::max(u[i] + step * direction[i], 0.0);
        normalise(next);
        reached = slope_at(next);
        raised = reached - value;
        if (raised >= -kTiny) break;
        step *= kBack;
      }
      double moved = 0.0;
      for (std::size_t i = 0; i < n; ++i) moved += (next[i] - u[i]) * (next[i] - u[i]);
      value = reached;
      u.swap(next);
      if (std::sqrt(moved) < kMoved || std::fabs(raised) < kRaised) break;
    }
    const double more = price(contradicted);
    if (!contradicted) break;
    d += more;
  }
  Chosen order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return u[a] > u[b]; });
  order.resize(std::min(n, static_cast<std::size_t>(std::lround(std::max(value, 0.0)))));
  return order;
}

Chosen densest_core(const std::vector<SweptPair>& pairs, double eps_m) {
  const Scores graph = score_pairs(pairs, eps_m);
  const std::size_t n = graph.size();
  std::vector<std::uint32_t> degree(n), order(n), place(n), first(n + 1, 0);
  for (std::size_t v = 0; v < n; ++v) ++first[degree[v] = graph.begin[v + 1] - graph.begin[v]];
  for (std::uint32_t d = 0, at = 0; d <= n; ++d) {
    const std::uint32_t here = first[d];
    first[d] = at;
    at += here;
  }
  for (std::uint32_t v = 0; v < n; ++v) order[place[v] = first[degree[v]]++] = v;
  for (std::size_t d = n; d > 0; --d) first[d] = first[d - 1];
  first[0] = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t v = order[i];
    for (std::uint32_t at = graph.begin[v]; at < graph.begin[v + 1]; ++at) {
      const std::uint32_t other = graph.other[at];
      if (degree[other] <= degree[v]) continue;
      const std::uint32_t to = first[degree[other]]++, moved = order[to];
      std::swap(order[place[other]], order[to]);
      std::swap(place[other], place[moved]);
      --degree[other];
    }
  }
  Chosen chosen;
  const std::uint32_t most = n == 0 ? 0 : *std::max_element(degree.begin(), degree.end());
  for (std::uint32_t v = 0; v < n; ++v) {
    if (degree[v] == most) chosen.push_back(v);
  }
  return chosen;
}

}  // namespace sortie::bench
