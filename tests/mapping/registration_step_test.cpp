// SPDX-License-Identifier: BSD-3-Clause
// One step of matching against a brute-force twin in Eigen; its gradient against the cost; its solver.
#include "mapping/registration/scan_step.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>

#include "mapping/registration/weak_directions.hpp"
#include "tests/mapping/registration_rig.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;
using testing::Matrix6;
using testing::Vector6;

Eigen::Vector3d as_eigen(const rt::Vector3& v) { return {v.x, v.y, v.z}; }
Eigen::Quaterniond as_eigen(const rt::Quaternion& q) { return {q.w, q.x, q.y, q.z}; }
Eigen::Vector3d as_eigen(const float (&v)[3]) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}
Matrix6 as_eigen(const double (&m)[6][6]) {
  Matrix6 out;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) out(i, k) = m[i][k];
  }
  return out;
}

/// One residual: the returns of a cell, along its surfel's normal.
struct StepRow {
  std::vector<Eigen::Vector3d> returns;  ///< sensor frame
  Eigen::Vector3d axis, lever;
  double residual{}, sureness{};  ///< returns that count, over their variance
};

struct StepTwin {
  std::vector<StepRow> rows;
  Matrix6 held = Matrix6::Zero(), h = Matrix6::Zero(), noise = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double squares{}, weight{};
};

/// The equations as they are described, by floor, std::map and dense matrices.
StepTwin step_twin(const mapping::SurfelLayer& layer, const std::vector<mapping::SamplePoint>& sample,
                   const mapping::RigidPose& pose, const mapping::StepRule& rule) {
  const double edge = layer.cell_m(), step = edge / 4096;
  const Eigen::Matrix3d r = as_eigen(pose.q).toRotationMatrix();
  struct Held {
    std::vector<Eigen::Vector3d> sensor, in_cell;
  };
  std::map<std::array<int, 4>, Held> groups;
  for (const mapping::SamplePoint& point : sample) {
    const Eigen::Vector3d v(static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                            static_cast<double>(point.z_m));
    const Eigen::Vector3d p = (r * v + as_eigen(pose.p)) / edge;
    const Eigen::Vector3d low = p.array().floor();
    const mapping::SurfelCell cell{
        {static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(low.z())}};
    const Eigen::Vector3d ray = r * v;
    const int side = testing::is_from_behind(layer, cell, {ray.x(), ray.y(), ray.z()}) ? 1 : 0;
    Held& held = groups[{cell.at[0], cell.at[1], cell.at[2], side}];
    held.sensor.push_back(v);
    held.in_cell.push_back(step * (((p - low) * 4096).array().floor() - 2048).matrix());
  }
  StepTwin twin;
  for (const auto& [at, held] : groups) {
    const mapping::SurfelCell cell{{at[0], at[1], at[2]}};
    mapping::SurfelIndex index = layer.find(cell);
    if (index != mapping::kNoSurfel && at[3] == 1) index = layer.other_side(index);
    if (index == mapping::kNoSurfel || layer.surfel(index).count == 0) continue;
    const mapping::Surfel* const surfel = &layer.surfel(index);
    const Eigen::Vector3d variance = as_eigen(surfel->variance_m2);
    if (variance[1] < 4 * variance[0] || variance[1] < 0.0036 * edge * edge) continue;
    const auto n = static_cast<double>(held.in_cell.size());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : held.in_cell) mean += p / n;
    const Eigen::Vector3d centre = edge * Eigen::Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
    if (std::sqrt(variance[0]) > edge / 4) continue;
    const Eigen::Vector3d a = as_eigen(surfel->axis[0]);
    double own = 0;
    for (const Eigen::Vector3d& p : held.in_cell) own += std::pow(a.dot(p - mean), 2) / n;
    StepRow row;
    row.returns = held.sensor;
    row.axis = a;
    row.lever = centre + mean - as_eigen(pose.p);
    row.residual = a.dot(mean - as_eigen(surfel->mean_m));
    row.sureness = std::min(n, 8.0) / (variance[0] + own + rule.sigma_m * rule.sigma_m);
    const double s2 = rule.scale_m * rule.scale_m;
    const double weight = row.sureness * std::pow(s2 / (s2 + row.residual * row.residual), 2);
    Vector6 j;
    j << row.lever.cross(a), a;
    twin.h += weight * j * j.transpose();
    twin.g += weight * row.residual * j;
    twin.squares += weight * row.residual * row.residual;
    twin.weight += weight;
    const Eigen::Vector3d at_map = centre + as_eigen(surfel->mean_m) - as_eigen(pose.p);
    j << at_map.cross(a), a;
    twin.held += weight * j * j.transpose();
    for (int k = 1; k < 3; ++k) {
      const double angle2 =
          (variance[0] + 0.1 * rule.sigma_m * rule.sigma_m) / variance[k] * (1.0 / surfel->count + 0.03);
      Vector6 t;
      t << at_map.cross(as_eigen(surfel->axis[k])), as_eigen(surfel->axis[k]);
      twin.noise += weight * angle2 * t * t.transpose();
    }
    twin.rows.push_back(row);
  }
  return twin;
}

/// A hall's surfels and a scan of it at a pose that is a bit off.
struct StepScene {
  testing::OwnedSurfelLayer owned{0.4, 7, 5, 16384};
  std::vector<mapping::StepMemory::Slot> slots{std::vector<mapping::StepMemory::Slot>(16384)};
  std::vector<mapping::CellSums> cells{std::vector<mapping::CellSums>(8192)};
  mapping::ScanStep step{{slots, cells}};
  std::vector<mapping::SamplePoint> sample;
  mapping::RigidPose pose;

  explicit StepScene(testing::Draws& draws) {
    const testing::RegistrationWorld world = testing::small_room(draws);
    testing::TestLidar lidar;
    lidar.columns = 240;
    for (std::uint32_t scan = 1; scan <= 3; ++scan) {
      const mapping::RigidPose at{{0.3 * scan, 0.1 * scan, 1.2}, rt::exp_rotation({0, 0, 0.1 * scan})};
      owned.insert(testing::placed(lidar.scan(world, at.p, at.q, draws), at), scan, at.p);
    }
    pose = {{draws.uniform(-0.5, 0.5), draws.uniform(-0.5, 0.5), 1.2}, rt::exp_rotation(draws.direction())};
    lidar.columns = 60;
    sample = testing::as_sample(lidar.scan(world, pose.p, pose.q, draws));
    pose.p = pose.p + draws.uniform(0, 0.1) * draws.direction();
    pose.q = rt::exp_rotation(draws.uniform(0, 0.02) * draws.direction()) * pose.q;
  }
};

Matrix6 drawn_spd(testing::Draws& draws, double decades) {
  Matrix6 m;
  for (int i = 0; i < 36; ++i) m(i / 6, i % 6) = draws.normal();
  const Matrix6 q = testing::singular_of(m).u;
  Vector6 values;
  for (int i = 0; i < 6; ++i) values[i] = std::pow(10.0, -decades * i / 5.0);
  const Matrix6 a = q * values.asDiagonal() * q.transpose();
  return 0.5 * (a + a.transpose());
}

void store6(const Matrix6& m, double (&out)[6][6]) {
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) out[i][k] = m(i, k);
  }
}
}  // namespace

TEST_CASE("The equations of a scan are those of a brute-force twin") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 6; ++run) {
    StepScene scene(draws);
    const mapping::StepRule rule{draws.uniform(0.05, 0.5), draws.uniform(0.005, 0.05), run % 2 == 0};
    const mapping::NormalEquations found =
        scene.step.equations(scene.owned.layer, scene.sample, scene.pose, rule);
    const StepTwin twin = step_twin(scene.owned.layer, scene.sample, scene.pose, rule);
    REQUIRE(twin.rows.size() > 60);
    CHECK(found.rows == twin.rows.size());
    CHECK((as_eigen(found.h) - twin.h).norm() < 1e-8 * twin.h.norm());
    CHECK((Vector6(found.g) - twin.g).norm() < 1e-8 * (twin.h.norm() * 0.01 + twin.g.norm()));
    CHECK(std::fabs(found.squares - twin.squares) < 1e-8 * twin.squares);
    if (rule.noise) {
      CHECK((as_eigen(found.noise) - twin.noise).norm() < 1e-8 * twin.noise.norm());
      CHECK((as_eigen(found.held) - twin.held).norm() < 1e-8 * twin.held.norm());
    } else {
      CHECK(as_eigen(found.held).norm() == 0.0);
      CHECK(as_eigen(found.noise).norm() == 0.0);
    }
    // Sums are in the order of the sample; but for rounding, that does not matter.
    testing::shuffle(scene.sample, draws);
    const mapping::NormalEquations other =
        scene.step.equations(scene.owned.layer, scene.sample, scene.pose, rule);
    CHECK(other.rows == found.rows);
    CHECK((as_eigen(other.h) - as_eigen(found.h)).norm() < 1e-12 * twin.h.norm());
  }
}

TEST_CASE("The gradient of a step is that of its cost, with every return in the cell that it was in") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 4; ++run) {
    StepScene scene(draws);
    const mapping::StepRule rule{0.08, 0.02, false};
    const mapping::NormalEquations found =
        scene.step.equations(scene.owned.layer, scene.sample, scene.pose, rule);
    const StepTwin twin = step_twin(scene.owned.layer, scene.sample, scene.pose, rule);
    // Half the sum of Geman and McClure's function over the residuals, after a turn about the sensor and a
    // move; a residual changes by what the mean of its returns moves.
    const auto cost = [&](const Vector6& x) {
      const Eigen::Vector3d w = x.head<3>();
      const double angle = w.norm();
      const Eigen::Matrix3d by =
          angle > 0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
      const Eigen::Matrix3d r = as_eigen(scene.pose.q).toRotationMatrix();
      double sum = 0;
      for (const StepRow& row : twin.rows) {
        Eigen::Vector3d moved = Eigen::Vector3d::Zero();
        for (const Eigen::Vector3d& v : row.returns)
          moved += (by * r * v - r * v) / static_cast<double>(row.returns.size());
        const double residual = row.residual + row.axis.dot(moved + x.tail<3>());
        const double s2 = rule.scale_m * rule.scale_m, r2 = residual * residual;
        sum += 0.5 * row.sureness * s2 * r2 / (s2 + r2);
      }
      return sum;
    };
    for (int i = 0; i < 6; ++i) {
      const double by = 1e-5;
      const double slope = (cost(by * Vector6::Unit(i)) - cost(-by * Vector6::Unit(i))) / (2 * by);
      // Levers are of means that were rounded to a step: 0.1 mm in some metres.
      CHECK(std::fabs(slope - found.g[i]) < 1e-5 * twin.weight);
    }
  }
}

TEST_CASE("Six equations are solved as Eigen solves them, and refused where nothing holds an unknown") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 200; ++run) {
    const double decades = run % 11;
    const double scale = std::pow(10.0, draws.uniform(-6, 12));
    const Matrix6 a = scale * drawn_spd(draws, decades);
    Vector6 b;
    for (int i = 0; i < 6; ++i) b[i] = scale * draws.normal();
    double m[6][6], x[6], inverse[6][6];
    store6(a, m);
    double right[6];
    for (int i = 0; i < 6; ++i) right[i] = b[i];
    REQUIRE(mapping::solve6(m, right, x));
    REQUIRE(mapping::invert6(m, inverse));
    const Vector6 twin = testing::solved(a, b);
    const double within = 3e-14 * std::pow(10.0, decades);
    CHECK((Vector6(x) - twin).norm() <= within * twin.norm());
    CHECK((a * Vector6(x) - b).norm() <= 1e-13 * a.norm() * twin.norm());
    const Matrix6 inverted = testing::inverted(a);
    CHECK((as_eigen(inverse) - inverted).norm() <= 10 * within * inverted.norm());
  }
  // What cancels by more than twelve digits is not told from nothing; but units alone do not make a matrix
  // bad.
  for (int run = 0; run < 50; ++run) {
    double m[6][6], x[6];
    const double b[6] = {1, -2, 3, -4, 5, -6};
    store6(drawn_spd(draws, 14), m);
    if (mapping::solve6(m, b, x)) {
      CHECK((as_eigen(m) * Vector6(x) - Vector6(b)).norm() < 1e-2 * Vector6(b).norm());
      CHECK(std::isfinite(Vector6(x).norm()));
    }
    Vector6 units;
    for (int i = 0; i < 6; ++i) units[i] = std::pow(10.0, draws.uniform(-7, 7));
    const Matrix6 scaled = units.asDiagonal() * drawn_spd(draws, 2) * units.asDiagonal();
    store6(0.5 * (scaled + scaled.transpose()), m);
    REQUIRE(mapping::solve6(m, b, x));
    const Vector6 residual = units.cwiseInverse().asDiagonal() * (as_eigen(m) * Vector6(x) - Vector6(b));
    CHECK(residual.norm() < 1e-10 * (units.cwiseInverse().asDiagonal() * Vector6(b)).norm());
    // Five rows hold five unknowns at most; these leave them free to move all alike.
    Eigen::Matrix<double, 5, 6> rows;
    for (int i = 0; i < 30; ++i) rows(i / 6, i % 6) = draws.normal();
    const Vector6 free = Vector6::Ones() / std::sqrt(6.0);
    rows -= rows * free * free.transpose();
    store6(rows.transpose() * rows, m);
    CHECK(!mapping::solve6(m, b, x));
    double inverse[6][6];
    CHECK(!mapping::invert6(m, inverse));
  }
  double m[6][6]{}, x[6];
  const double b[6]{};
  CHECK(!mapping::solve6(m, b, x));
  for (int i = 0; i < 6; ++i) m[i][i] = 1;
  m[2][2] = std::numeric_limits<double>::quiet_NaN();
  CHECK(!mapping::solve6(m, b, x));
  m[2][2] = std::numeric_limits<double>::infinity();
  CHECK(!mapping::solve6(m, b, x));
  m[2][2] = -1;
  CHECK(!mapping::solve6(m, b, x));
}

TEST_CASE("A pose goes to its prior where nothing else is known, stays where nothing is, and else between") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 50; ++run) {
    mapping::PosePrior prior;
    prior.at = {draws.uniform(0, 100) * draws.direction(), rt::exp_rotation(2.0 * draws.direction())};
    const rt::Vector3 turn = draws.uniform(0, 1) * draws.direction(), move = draws.direction();
    const mapping::RigidPose start{prior.at.p + move, rt::exp_rotation(turn) * prior.at.q};
    mapping::RigidPose pose = start;
    CHECK(!mapping::ScanStep::advance({}, prior, pose));
    CHECK(std::memcmp(&pose, &start, sizeof(pose)) == 0);
    const Matrix6 information = 1e4 * drawn_spd(draws, 4);
    store6(information, prior.information);
    REQUIRE(mapping::ScanStep::advance({}, prior, pose));
    CHECK(rt::norm(pose.p - prior.at.p) < 1e-9);
    CHECK(rt::norm(rt::log_rotation(pose.q * rt::conjugate(prior.at.q))) < 1e-9);
    // With equations: the minimum of both.
    mapping::NormalEquations equations;
    const Matrix6 h = 1e5 * drawn_spd(draws, 3);
    store6(h, equations.h);
    Vector6 g, from;
    for (int i = 0; i < 6; ++i) g[i] = equations.g[i] = 1e3 * draws.normal();
    from << as_eigen(turn), as_eigen(move);
    const Vector6 x = testing::solved(h + information, -g - information * from);
    pose = start;
    REQUIRE(mapping::ScanStep::advance(equations, prior, pose));
    const rt::Quaternion wanted = rt::exp_rotation({x[0], x[1], x[2]}) * start.q;
    CHECK(rt::norm(rt::log_rotation(pose.q * rt::conjugate(wanted))) < 1e-8);
    CHECK((as_eigen(pose.p - start.p) - x.tail<3>()).norm() < 1e-8);
  }
}

TEST_CASE("A scan that meets no surface gives no equations") {
  testing::Draws draws(5);
  StepScene scene(draws);
  mapping::RigidPose far = scene.pose;
  const auto nothing = [&](const mapping::NormalEquations& e) {
    return e.rows == 0 && as_eigen(e.h).norm() == 0.0;
  };
  CHECK(nothing(scene.step.equations(scene.owned.layer, {}, scene.pose, {})));
  for (const double at : {500.0, 1e7, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    far.p.x = at;
    CHECK(nothing(scene.step.equations(scene.owned.layer, scene.sample, far, {0.1, 0.02, true})));
  }
  CHECK(!nothing(scene.step.equations(scene.owned.layer, scene.sample, scene.pose, {})));
}
