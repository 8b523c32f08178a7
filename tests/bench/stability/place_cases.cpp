// SPDX-License-Identifier: BSD-3-Clause
// Places that seem to be known: mirror images, rooms that are alike, rows, earth-centred numbers, corridors.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "mapping/recognition/set_hypotheses.hpp"
#include "mapping/registration/weak_directions.hpp"
#include "tests/bench/stability/cases.hpp"
#include "tests/mapping/level_places.hpp"

namespace sortie::bench {

namespace {

using mapping::PlaceCm;
using mapping::SweptPair;
using rt::Vector3;
using testing::any_level_pose;
using testing::LevelPose;
using testing::rounded;
using testing::scattered;

void pair(std::vector<SweptPair>& pairs, std::size_t segment, const Vector3& at, const Vector3& target) {
  const auto number = static_cast<std::uint16_t>(pairs.size());
  pairs.push_back({{static_cast<std::uint16_t>(segment), number}, rounded(at), rounded(target)});
}

/// Searched as `recognise` does.
struct Search {
  std::vector<std::byte> memory = std::vector<std::byte>(1 << 20);
  rt::Arena arena{memory};
  mapping::SetHypotheses sets{256, arena};

  bool finds(const std::vector<SweptPair>& pairs) {
    std::uint64_t units = ~std::uint64_t{0};
    return sets.begin({}, pairs) == Status::ok && sets.run(units) &&
           sets.verdict() == mapping::SetVerdict::found;
  }
};

double apart_m(const PlaceCm& a, const PlaceCm& b) {
  return 0.01 * std::hypot(static_cast<double>(a.x) - b.x, static_cast<double>(a.y) - b.y,
                           static_cast<double>(a.z) - b.z);
}

/// The published test and nothing else: distances in space agree to 0.4 m (R. Dube et al., RA-L 2018,
/// eq. 10); the set that begins with the first pair, grown greedily, is a place where it has six.
std::vector<std::uint16_t> greedy_set(const std::vector<SweptPair>& pairs) {
  std::vector<std::uint16_t> set;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto agrees = [&](std::uint16_t k) {
      const SweptPair &a = pairs[i], &b = pairs[k];
      return a.pair.segment != b.pair.segment && a.pair.target != b.pair.target &&
             std::fabs(apart_m(a.segment, b.segment) - apart_m(a.target, b.target)) <= 0.4;
    };
    if (std::all_of(set.begin(), set.end(), agrees)) set.push_back(static_cast<std::uint16_t>(i));
  }
  return set;
}

constexpr int kTries = 100;
constexpr std::size_t kEnough = 6;

/// How many of kTries places, made by `make(draws, pairs)`, each method takes for one.
template <class Make>
StabilityFigures taken_of(const Make& make) {
  testing::Draws draws(20'261);
  Search search;
  StabilityFigures taken;
  for (int run = 0; run < kTries; ++run) {
    std::vector<SweptPair> pairs;
    make(draws, pairs);
    taken.ours += search.finds(pairs) ? 1 : 0;
    taken.naive += greedy_set(pairs).size() >= kEnough ? 1 : 0;
  }
  return taken;
}

/// A corridor along x, 50 m to both ends, with normals that are off by 3 mrad.
mapping::NormalEquations corridor() {
  testing::Draws draws(7);
  mapping::NormalEquations out;
  const auto add = [&out](double(&to)[6][6], const Vector3& at, const Vector3& normal, double weight) {
    const Vector3 lever = cross(at, normal);
    const double j[6] = {lever.x, lever.y, lever.z, normal.x, normal.y, normal.z};
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < 6; ++k) to[i][k] += weight * j[i] * j[k];
    }
  };
  constexpr double kOff = 0.003;
  for (int i = 0; i < 1'800; ++i) {
    const double x = draws.uniform(-50, 50), u = draws.uniform(-1, 1);
    const bool floor = i % 3 == 0;
    const Vector3 exact = floor ? Vector3{0, 0, 1} : Vector3{0, 1, 0};
    const Vector3 at = floor ? Vector3{x, 1.2 * u, -0.8} : Vector3{x, i % 3 == 1 ? 1.1 : -1.3, u};
    const Vector3 along{1, 0, 0}, across = cross(exact, along);
    const Vector3 n = exact + kOff * draws.normal() * along + kOff * draws.normal() * across;
    add(out.h, at, (1.0 / norm(n)) * n, 1e4);
    for (const Vector3& t : {along, across}) add(out.noise, at, t, 1e4 * kOff * kOff);
  }
  std::copy(&out.h[0][0], &out.h[0][0] + 36, &out.held[0][0]);
  return out;
}

/// What is between a direction and the corridor's, rad.
double off_axis(const Vector3& direction) {
  return std::atan2(std::hypot(direction.y, direction.z), std::fabs(direction.x));
}

/// Eigenvectors of a symmetric 6x6 as columns of `v`, its eigenvalues on the diagonal of `a` (Jacobi).
void diagonalise(double (&a)[6][6], double (&v)[6][6]) {
  for (int i = 0; i < 6; ++i) v[i][i] = 1;
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (int p = 0; p < 5; ++p) {
      for (int q = p + 1; q < 6; ++q) {
        const double turn = 0.5 * std::atan2(2 * a[p][q], a[q][q] - a[p][p]);
        const double c = std::cos(turn), s = std::sin(turn);
        const auto rotate = [c, s](double& x, double& y) {
          const double of_x = c * x - s * y;
          y = s * x + c * y;
          x = of_x;
        };
        for (int k = 0; k < 6; ++k) rotate(a[k][p], a[k][q]);
        for (int k = 0; k < 6; ++k) rotate(a[p][k], a[q][k]);
        for (int k = 0; k < 6; ++k) rotate(v[k][p], v[k][q]);
      }
    }
  }
}

}  // namespace

StabilityFigures mirrored_place() {
  return taken_of([](testing::Draws& draws, std::vector<SweptPair>& pairs) {
    const LevelPose there = any_level_pose(draws);
    for (const Vector3& p : scattered(12, 12, draws)) pair(pairs, pairs.size(), p, there({p.x, -p.y, p.z}));
  });
}

StabilityFigures rooms_alike() {
  return taken_of([](testing::Draws& draws, std::vector<SweptPair>& pairs) {
    const std::vector<Vector3> room = scattered(12, 12, draws);
    const LevelPose one = any_level_pose(draws), other = any_level_pose(draws);
    for (const LevelPose& there : {one, other}) {
      for (std::size_t i = 0; i < room.size(); ++i) pair(pairs, i, room[i], there(room[i]));
    }
  });
}

StabilityFigures things_in_a_row() {
  testing::Draws draws(11);
  Search search;
  StabilityFigures worst;
  for (int run = 0; run < kTries; ++run) {
    const LevelPose there = any_level_pose(draws);
    std::vector<SweptPair> pairs;
    std::vector<std::uint16_t> all;
    // A stack: above each other, and each seen off by 15 cm.
    for (std::size_t i = 0; i < 8; ++i) {
      const Vector3 p{7, 3, 0.4 * static_cast<double>(i)};
      const auto off = [&draws] { return draws.uniform(-0.15, 0.15); };
      pair(pairs, i, p + Vector3{off(), off(), 0}, there(p) + Vector3{off(), off(), 0});
      all.push_back(static_cast<std::uint16_t>(i));
    }
    const double c = std::cos(there.yaw), sine = std::sin(there.yaw);
    const auto turned = [c, sine](const mapping::LevelPlace& p) {
      return std::fabs(std::atan2(p.sine * c - p.cosine * sine, p.cosine * c + p.sine * sine));
    };
    mapping::LevelFit fit;
    if (mapping::fit_level(pairs, all, fit)) keep_worst(worst.naive, turned(fit.place));
    if (search.finds(pairs)) keep_worst(worst.ours, turned(search.sets.found()[0].fit.place));
  }
  return worst;
}

StabilityFigures earth_centred_places() {
  testing::Draws draws(13);
  const mapping::ConsistencyGates gates;
  StabilityFigures missed;
  for (int run = 0; run < 1'000; ++run) {
    // Somewhere in Europe, metres from the earth's centre; both maps are the same.
    const Vector3 origin{4.02e6, 5.8e5, 4.93e6};
    const auto place = [&draws] {
      return Vector3{draws.uniform(-20, 20), draws.uniform(-20, 20), draws.uniform(-1, 1)};
    };
    const Vector3 a = place(), b = place();
    const SweptPair one{{0, 0}, rounded(a), rounded(a + origin)};
    const SweptPair two{{1, 1}, rounded(b), rounded(b + origin)};
    // By 20 cm, the narrow one of the three gates.
    missed.ours += mapping::gates_passed(gates, one, two) == 3 ? 0 : 1;
    const auto in_float = [](const PlaceCm& p, const PlaceCm& q) {
      const auto m = [](std::int32_t cm) { return 0.01f * static_cast<float>(cm); };
      const float x = m(p.x) - m(q.x), y = m(p.y) - m(q.y), z = m(p.z) - m(q.z);
      return static_cast<double>(std::sqrt(x * x + y * y + z * z));
    };
    missed.naive += std::fabs(in_float(one.segment, two.segment) - in_float(one.target, two.target)) > 0.2;
  }
  return missed;
}

StabilityFigures corridor_axis() {
  const mapping::NormalEquations equations = corridor();
  const mapping::WeakDirections weak = mapping::weak_directions(equations, 4.0);
  StabilityFigures off;
  off.ours = weak.moves == 1 && weak.turns == 0 ? off_axis(weak.move[0]) : std::nan("");
  // All six together: weak is what has less than a thousandth of the most.
  double a[6][6], v[6][6]{};
  std::copy(&equations.h[0][0], &equations.h[0][0] + 36, &a[0][0]);
  diagonalise(a, v);
  double most = 0;
  for (int i = 0; i < 6; ++i) most = std::max(most, a[i][i]);
  for (int i = 0; i < 6; ++i) {
    if (a[i][i] < 1e-3 * most) keep_worst(off.naive, off_axis({v[3][i], v[4][i], v[5][i]}));
  }
  return off;
}

}  // namespace sortie::bench
