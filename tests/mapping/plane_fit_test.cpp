// SPDX-License-Identifier: BSD-3-Clause
// The weighted fit of pairs of planes against Eigen's singular values, exact scenes, and its own covariance.
#include "mapping/registration/plane_fit.hpp"

#include <catch2/catch.hpp>
#include <numeric>

#include "mapping/registration/plane_algebra.hpp"
#include "tests/mapping/plane_scenes.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;

Eigen::Vector3d eigen(const rt::Vector3& v) { return {v.x, v.y, v.z}; }

/// Sets of the same planes, pair by pair.
struct Pairs {
  std::vector<mapping::Plane> source;
  std::vector<mapping::Plane> target;
  std::vector<mapping::PlanePair> pairs;

  void add(const mapping::Plane& s, const mapping::Plane& t) {
    const auto at = static_cast<std::uint16_t>(source.size());
    source.push_back(s);
    target.push_back(t);
    pairs.push_back({at, at, false});
  }
};

mapping::PlaneFit fit(const Pairs& p, const mapping::PlanePose& start, const mapping::PlaneEstimate& estimate,
                      const mapping::PlaneFitConfig& config = {}, int steps = 6) {
  return mapping::fit_planes(p.source, p.target, p.pairs, start, estimate, config, steps);
}

mapping::PlaneEstimate guess(const rt::Vector3& p, double sigma_m) {
  mapping::PlaneEstimate e;
  e.T_target_source.p_target_source_m = p;
  e.sigma_position_m = sigma_m;
  e.sigma_yaw_rad = 0.1;
  return e;
}

/// Planes with exact normals and offsets that differ by `off(k)` of a shift; turns are held by the tilts.
Pairs shifted(const std::vector<rt::Vector3>& normals, const rt::Vector3& shift, double noise_m, double scale,
              tests::WorldRandom& random) {
  Pairs p;
  for (const rt::Vector3& n : normals) {
    const double x = random.between(-10, 10);
    const double y = random.between(-10, 10);
    mapping::Plane s = tests::rectangle(n, {x, y, random.between(-3, 3)}, {n.y, n.z, n.x}, 2, 1);
    s.sigma_tilt_rad[0] = s.sigma_tilt_rad[1] = 1e-8;
    s.sigma_offset_m = random.between(0.005, 0.03);
    mapping::Plane t = s;
    t.centroid_m = scale * s.centroid_m + shift + (noise_m * random.normal()) * s.normal;
    t.offset_m = rt::dot(t.normal, t.centroid_m);
    t.sigma_offset_m = random.between(0.005, 0.03);
    p.add(s, t);
  }
  return p;
}

mapping::PlaneFitConfig exact_config() {
  mapping::PlaneFitConfig config;
  config.model_sigma_m = config.model_sigma_rad = 1e-9;
  return config;
}
}  // namespace

TEST_CASE("Translation is the pseudo-inverse's where singular values are good, the estimate's where not") {
  constexpr std::uint32_t kSeed = 21;
  tests::WorldRandom random(kSeed);
  CAPTURE(kSeed);
  std::uint32_t ranks[4]{};
  for (int trial = 0; trial < 400; ++trial) {
    // Normals near a line, near a plane, or anywhere; a few of them close to the threshold.
    const int kind = trial % 4;
    std::vector<rt::Vector3> normals;
    const double spread = std::exp(random.between(-9, 0));
    for (std::uint32_t k = 0; k < 3 + random.below(8); ++k) {
      const double a = random.between(-1, 1), b = random.between(-1, 1), c = random.between(-1, 1);
      rt::Vector3 n{a, b, c};
      if (kind == 0) n = {1, spread * a, spread * b};
      if (kind == 1) n = {a, b, spread * c};
      if (rt::norm(n) < 0.2) n = {0, 0, 1};
      normals.push_back((1.0 / rt::norm(n)) * n);
    }
    const rt::Vector3 shift{0.3, -0.2, 0.1};
    const Pairs p = shifted(normals, shift, 0.01, 1.0, random);
    const rt::Vector3 given{random.between(-1, 1), 0.5, -0.25};
    const mapping::PlaneFit f = fit(p, {}, guess(given, 1.0), exact_config(), 4);
    REQUIRE(f.finite);

    const auto rows = static_cast<Eigen::Index>(normals.size());
    Eigen::MatrixXd n(rows, 3);
    Eigen::VectorXd d(rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double sigma = std::hypot(p.source[i].sigma_offset_m, p.target[i].sigma_offset_m);
      n.row(k) = eigen(p.target[i].normal).transpose() / sigma;
      d[k] = (p.target[i].offset_m - p.source[i].offset_m) / sigma;
    }
    const testing::Singular svd = testing::singular_of(n);
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
    int rank = 0;
    bool close = false;  // so near the threshold that rounding decides
    for (int i = 0; i < 3; ++i) {
      const double sigma = svd.values[i];
      const Eigen::Vector3d v = svd.v.col(i);
      close = close || std::fabs(1 / sigma - 0.05) < 1e-6;
      if (1 / sigma < 0.05) {
        t += svd.u.col(i).dot(d) / sigma * v;
        ++rank;
      } else {
        t += eigen(given).dot(v) * v;
      }
    }
    if (close) continue;
    ++ranks[rank];
    CHECK(f.translation_rank == rank);
    CHECK(f.rotation_rank == 3);
    CHECK((eigen(f.T_target_source.p_target_source_m) - t).norm() < 1e-5);
  }
  CHECK(ranks[1] > 20);
  CHECK(ranks[2] > 20);
  CHECK(ranks[3] > 100);
}

TEST_CASE("Scale is the fourth column of the same system") {
  tests::WorldRandom random(22);
  std::uint32_t whole = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<rt::Vector3> normals;
    for (std::uint32_t k = 0; k < 8 + random.below(8); ++k) {
      const double a = random.between(-1, 1), b = random.between(-1, 1);
      const rt::Vector3 n{a, b, random.between(0.1, 1)};
      normals.push_back((1.0 / rt::norm(n)) * n);
    }
    const Pairs p = shifted(normals, {0.3, -0.2, 0.1}, 0.01, random.between(0.95, 1.05), random);
    mapping::PlaneEstimate estimate = guess({}, 0.0);
    estimate.sigma_scale = 0.05;
    const mapping::PlaneFit f = fit(p, {}, estimate, exact_config(), 8);
    REQUIRE(f.finite);
    if (f.translation_rank < 4) continue;
    ++whole;
    // Weights of the twin are those at the solution: a source's error grows with the scale.
    const auto rows = static_cast<Eigen::Index>(normals.size());
    Eigen::MatrixXd n(rows, 4);
    Eigen::VectorXd d(rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double sigma =
          std::hypot(f.T_target_source.scale * p.source[i].sigma_offset_m, p.target[i].sigma_offset_m);
      n.row(k) << eigen(p.target[i].normal).transpose() / sigma, p.source[i].offset_m / sigma;
      d[k] = p.target[i].offset_m / sigma;
    }
    const Eigen::Vector4d x = testing::least_squares(n, d);
    CHECK(f.T_target_source.scale == Approx(x[3]).margin(1e-6));
    CHECK((eigen(f.T_target_source.p_target_source_m) - x.head<3>()).norm() < 1e-4);
  }
  CHECK(whole > 150);
}

TEST_CASE("Exact planes give the exact pose, near and 100 km from the origin") {
  tests::WorldRandom random(23);
  for (const double far : {0.0, 1e5}) {
    for (int trial = 0; trial < 50; ++trial) {
      tests::PlaneNoise none{0, 0, 1};
      tests::PlaneScene s = tests::random_scene(8, 0, 0, 1.0, none, none, random);
      Pairs p;
      mapping::PlanePose truth = tests::random_pose(random, 30, 1.0);
      truth.p_target_source_m.x += far;
      for (const mapping::Plane& t : s.target) {
        mapping::Plane q = tests::carried(t, mapping::PlanePose{{}, {far, 0, 0}, 1});
        p.add(tests::carried(q, mapping::inverse(truth)), q);
      }
      mapping::PlanePose start = truth;
      start.q_target_source = rt::exp_rotation({0.01, -0.01, 0.02}) * truth.q_target_source;
      start.p_target_source_m = start.p_target_source_m + rt::Vector3{0.1, 0.1, -0.1};
      if (far > 0) start.q_target_source = truth.q_target_source;
      mapping::PlaneEstimate estimate;
      estimate.sigma_tilt_rad = 0;
      const mapping::PlaneFit f = fit(p, start, estimate);
      REQUIRE(f.finite);
      CHECK(f.rotation_rank == 3);
      CHECK(f.translation_rank == 3);
      CHECK(rt::norm(f.T_target_source.p_target_source_m - truth.p_target_source_m) <
            (far > 0 ? 1e-4 : 1e-8));
      CHECK(rt::norm(rt::log_rotation(f.T_target_source.q_target_source *
                                      rt::conjugate(truth.q_target_source))) < 1e-9);
    }
  }
}

TEST_CASE("Parallel planes: the turn about their normal and the way along them keep the estimate") {
  tests::WorldRandom random(24);
  Pairs p;
  for (const double z : {0.0, 1.0, 3.0}) {
    const mapping::Plane t = tests::rectangle({0, 0, 1}, {0.5 * z, -z, z}, {1, 0, 0}, 3, 2);
    p.add(tests::carried(t, mapping::inverse({rt::exp_rotation({0.01, 0.02, 0.3}), {0.2, 0.1, 0.05}, 1})), t);
  }
  mapping::PlaneEstimate estimate = guess({0.4, -0.3, 0.7}, 1.0);
  estimate.sigma_tilt_rad = 0;  // without gravity
  estimate.T_target_source.q_target_source = rt::exp_rotation({0, 0, 0.25});
  const mapping::PlaneFit f = fit(p, estimate.T_target_source, estimate);
  REQUIRE(f.finite);
  CHECK(f.rotation_rank == 2);
  CHECK(f.translation_rank == 1);
  CHECK(std::fabs(f.rotation_axis[0].z) == Approx(1.0).margin(1e-6));
  CHECK(rt::log_rotation(f.T_target_source.q_target_source).z == Approx(0.25).margin(2e-3));
  for (const mapping::Plane& s : p.source) {  // what they do say is right
    const auto at = static_cast<std::size_t>(&s - p.source.data());
    CHECK(std::fabs(rt::dot(p.target[at].normal, mapping::transform(f.T_target_source, s.centroid_m)) -
                    p.target[at].offset_m) < 1e-6);
  }
  // The pivot has moved along what is not seen to where the estimate has it.
  const rt::Vector3 given = mapping::transform(estimate.T_target_source, f.pivot_source_m);
  CHECK(f.pivot_target_m.x == Approx(given.x).margin(1e-6));
  CHECK(f.pivot_target_m.y == Approx(given.y).margin(1e-6));
}

TEST_CASE("The covariance is that of the errors: NEES of 1,000 fits, with and without a scale") {
  constexpr std::uint32_t kSeed = 25;
  CAPTURE(kSeed);
  for (const bool scaled : {false, true}) {
    tests::WorldRandom random(kSeed);
    double sum = 0.0;
    const int dimension = scaled ? 7 : 6;
    constexpr int kTrials = 1000;
    for (int trial = 0; trial < kTrials; ++trial) {
      tests::HallMaker hall(random, 20, 15, 5);
      hall.shell();
      hall.furnish(14);
      const mapping::PlanePose truth = tests::random_pose(random, 10, scaled ? 0.95 : 1.0);
      Pairs p;
      // The part that one sees is the part that the other sees: then errors are independent at one point.
      tests::PlaneNoise noise{0.01, 0.004, 0.999};
      for (const mapping::Plane& t : hall.planes) {
        mapping::Plane s = tests::carried(tests::seen(t, noise, random), mapping::inverse(truth));
        p.add(s, tests::seen(t, noise, random));
      }
      mapping::PlaneEstimate estimate;
      estimate.sigma_tilt_rad = 0;
      estimate.sigma_scale = scaled ? 0.1 : 0.0;
      const mapping::PlaneFit f = fit(p, truth, estimate, exact_config());
      REQUIRE(f.finite);
      const rt::Vector3 turn =
          rt::log_rotation(f.T_target_source.q_target_source * rt::conjugate(truth.q_target_source));
      const rt::Vector3 shift = f.pivot_target_m - mapping::transform(truth, f.pivot_source_m);
      Eigen::VectorXd e(dimension);
      e.head<6>() << turn.x, turn.y, turn.z, shift.x, shift.y, shift.z;
      if (scaled) e[6] = std::log(f.T_target_source.scale / truth.scale);
      Eigen::MatrixXd c(dimension, dimension);
      for (int i = 0; i < dimension; ++i) {
        for (int k = 0; k < dimension; ++k) c(i, k) = f.covariance[i][k];
      }
      sum += e.dot(testing::solved(c, e));
    }
    const double nees = sum / kTrials / dimension;
    CAPTURE(scaled);
    CHECK(nees > 0.85);
    CHECK(nees < 1.15);
  }
}

TEST_CASE("Errors of 1e-6 and of 1e3 side by side, a tilted vertical, and no pairs at all") {
  tests::WorldRandom random(26);
  std::vector<rt::Vector3> normals{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}};
  Pairs p = shifted(normals, {0.1, 0.2, 0.3}, 0.0, 1.0, random);
  for (std::size_t k = 0; k < p.source.size(); ++k) {
    const double sigma = k % 2 == 0 ? 1e-6 : 1e3;
    for (mapping::Plane* plane : {&p.source[k], &p.target[k]}) {
      plane->sigma_offset_m = sigma;
      plane->sigma_tilt_rad[0] = plane->sigma_tilt_rad[1] = sigma;
    }
  }
  p.target[3].centroid_m.x += 50;  // says nothing
  const mapping::PlaneFit f = fit(p, {}, guess({9, 9, 9}, 1.0), exact_config());
  REQUIRE(f.finite);
  CHECK(f.translation_rank == 3);
  CHECK(f.T_target_source.p_target_source_m.x == Approx(0.1).margin(1e-6));
  for (std::size_t k = 0; k < p.source.size(); ++k)
    p.source[k].sigma_offset_m = p.target[k].sigma_offset_m = 1e3;
  const mapping::PlaneFit unknown = fit(p, {}, guess({9, 9, 9}, 1.0), exact_config());
  REQUIRE(unknown.finite);
  CHECK(unknown.translation_rank == 0);
  CHECK(rt::norm(unknown.pivot_target_m - unknown.pivot_source_m - rt::Vector3{9, 9, 9}) < 1e-6);
  const mapping::PlaneFit none = fit({}, {}, guess({1, 2, 3}, 1.0));
  CHECK(none.translation_rank == 0);
  CHECK(none.T_target_source.p_target_source_m.x == Approx(1.0));
}

TEST_CASE("Eigenvectors by Jacobi's method are Eigen's, also of equal values and of values 1e16 apart") {
  tests::WorldRandom random(27);
  for (int trial = 0; trial < 2000; ++trial) {
    const rt::RotationMatrix r = rt::to_matrix(
        rt::exp_rotation({random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)}));
    double values[3];
    for (double& v : values) v = trial % 3 == 0 ? 1.0 + random.below(2) : std::exp(random.between(-20, 16));
    double a[3][3]{};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) a[i][j] += r.m[3 * i + k] * values[k] * r.m[3 * j + k];
      }
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < i; ++j) a[i][j] = a[j][i];
    }
    const mapping::EigenPairs<3> pairs = mapping::eigen_pairs(a);
    std::sort(values, values + 3);
    for (int k = 0; k < 3; ++k) {
      CHECK(std::fabs(pairs.value[k] - values[k]) < 1e-14 * values[2] * 10);
      double residual = 0.0;
      double length = 0.0;
      for (int i = 0; i < 3; ++i) {
        double image = -pairs.value[k] * pairs.vector[i][k];
        for (int j = 0; j < 3; ++j) image += a[i][j] * pairs.vector[j][k];
        residual = std::max(residual, std::fabs(image));
        length += pairs.vector[i][k] * pairs.vector[i][k];
      }
      CHECK(residual < 1e-13 * values[2]);
      CHECK(length == Approx(1.0).epsilon(1e-13));
    }
  }
}
