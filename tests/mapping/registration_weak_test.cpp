// SPDX-License-Identifier: BSD-3-Clause
// Weak directions of shapes whose null spaces are known.
#include "mapping/registration/weak_directions.hpp"

#include <catch2/catch.hpp>

#include "tests/mapping/registration_world.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;
using Eigen::Vector3d;
using testing::Matrix6;
using testing::Vector6;

/// Points with their normals, as seen from the sensor, and the motions that slide the shape along itself:
/// (turn, move) each.
struct WeakShape {
  const char* name;
  std::vector<std::pair<Vector3d, Vector3d>> points;
  std::vector<Vector6> free;
};

Vector6 motion(const Vector3d& turn, const Vector3d& move) {
  Vector6 z;
  z << turn, move;
  return z;
}
Vector3d drawn_unit(testing::Draws& draws) {
  const rt::Vector3 v = draws.direction();
  return {v.x, v.y, v.z};
}
/// A turn about an axis through a point other than the sensor.
Vector6 turn_about(const Vector3d& axis, const Vector3d& at) { return motion(axis, -axis.cross(at)); }

void add_plane(WeakShape& shape, testing::Draws& draws, const Vector3d& normal, double away) {
  const Vector3d a = normal.unitOrthogonal(), b = normal.cross(a);
  for (int i = 0; i < 600; ++i)
    shape.points.emplace_back(away * normal + draws.uniform(-5, 5) * a + draws.uniform(-5, 5) * b, normal);
}

std::vector<WeakShape> weak_shapes(testing::Draws& draws) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  std::vector<WeakShape> shapes;
  WeakShape plane{"plane", {}, {motion({0, 0, 0}, x), motion({0, 0, 0}, y), motion(z, {0, 0, 0})}};
  add_plane(plane, draws, z, -1.3);
  shapes.push_back(plane);
  WeakShape walls{"two walls", {}, {motion({0, 0, 0}, z)}};
  add_plane(walls, draws, x, 3);
  add_plane(walls, draws, y, -2);
  shapes.push_back(walls);
  WeakShape corridor{"corridor", {}, {motion({0, 0, 0}, x)}};
  add_plane(corridor, draws, y, 1.1);
  add_plane(corridor, draws, y, -1.3);
  add_plane(corridor, draws, z, -0.8);
  shapes.push_back(corridor);
  WeakShape room{"room", {}, {}};
  for (const Vector3d& axis : {x, y, z}) add_plane(room, draws, axis, 2.5);
  shapes.push_back(room);
  for (const bool centred : {true, false}) {
    const Vector3d at = centred ? Vector3d(0, 0, 0) : Vector3d(2, -1, 0.5);
    WeakShape ball{centred ? "sphere about the sensor" : "sphere", {}, {}};
    WeakShape tube{centred ? "cylinder about the sensor" : "cylinder", {}, {}};
    for (int i = 0; i < 600; ++i) {
      const Vector3d n = drawn_unit(draws);
      ball.points.emplace_back(at + 1.5 * n, n);
      const Vector3d around = Vector3d(n.x(), n.y(), 0).normalized();
      tube.points.emplace_back(at + 1.5 * around + draws.uniform(-5, 5) * z, around);
    }
    for (const Vector3d& axis : {x, y, z}) ball.free.push_back(turn_about(axis, at));
    tube.free = {motion({0, 0, 0}, z), turn_about(z, at)};
    shapes.push_back(ball);
    shapes.push_back(tube);
  }
  return shapes;
}

/// Its rank, and the projector onto the span of some vectors in space.
struct Span {
  int rank{};
  Eigen::Matrix3d onto = Eigen::Matrix3d::Zero();
};
Span span_of(const std::vector<Vector3d>& vectors) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Vector3d& v : vectors) sum += v * v.transpose();
  const testing::Eigen3 eigen = testing::eigen_of(sum);
  Span span;
  for (int i = 0; i < 3; ++i) {
    if (eigen.values[i] < 1e-6) continue;
    ++span.rank;
    span.onto += eigen.vectors.col(i) * eigen.vectors.col(i).transpose();
  }
  return span;
}

/// Equations of points on a shape whose normals are off by an angle, rad.
mapping::NormalEquations equations_of(const WeakShape& shape, double scale, double noise_rad,
                                      testing::Draws& draws) {
  Matrix6 h = Matrix6::Zero(), noise = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  for (const auto& [p, exact] : shape.points) {
    const Vector3d a = exact.unitOrthogonal(), b = exact.cross(a);
    const Vector3d n = (exact + noise_rad * draws.normal() * a + noise_rad * draws.normal() * b).normalized();
    const double weight = scale * draws.uniform(0.2, 1);
    const Vector6 j = motion(p.cross(n), n);
    h += weight * j * j.transpose();
    g += weight * 0.03 * draws.normal() * j;
    for (const Vector3d& t : {a, b}) {
      const Vector6 k = motion(p.cross(t), t);
      noise += weight * noise_rad * noise_rad * k * k.transpose();
    }
  }
  mapping::NormalEquations out;
  for (int i = 0; i < 6; ++i) {
    out.g[i] = g[i];
    for (int k = 0; k < 6; ++k) {
      out.h[i][k] = out.held[i][k] = 0.5 * (h(i, k) + h(k, i));
      out.noise[i][k] = 0.5 * (noise(i, k) + noise(k, i));
    }
  }
  return out;
}

Matrix6 matrix_of(const double (&m)[6][6]) {
  Matrix6 out;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) out(i, k) = m[i][k];
  }
  return out;
}

/// `noise_rad` 0: the normals are exact, and so is what has to be found.
void judge_weak(const WeakShape& shape, double scale, double noise_rad, testing::Draws& draws) {
  INFO(shape.name << ", scale " << scale << ", noise " << noise_rad);
  mapping::NormalEquations equations = equations_of(shape, scale, noise_rad, draws);
  const mapping::WeakDirections weak = mapping::weak_directions(equations, 4.0);
  std::vector<Vector3d> turns, moves, found_turns, found_moves;
  for (const Vector6& z : shape.free) {
    turns.push_back(z.head<3>());
    moves.push_back(z.tail<3>());
  }
  for (std::uint32_t i = 0; i < weak.turns; ++i)
    found_turns.emplace_back(weak.turn[i].x, weak.turn[i].y, weak.turn[i].z);
  for (std::uint32_t i = 0; i < weak.moves; ++i)
    found_moves.emplace_back(weak.move[i].x, weak.move[i].y, weak.move[i].z);
  REQUIRE(weak.turns == static_cast<std::uint32_t>(span_of(turns).rank));
  REQUIRE(weak.moves == static_cast<std::uint32_t>(span_of(moves).rank));
  const double within = noise_rad > 0 ? 0.1 : 1e-6;
  CHECK((span_of(turns).onto - span_of(found_turns).onto).norm() < within);
  CHECK((span_of(moves).onto - span_of(found_moves).onto).norm() < within);

  const Matrix6 before = matrix_of(equations.h);
  const Vector6 g_before(equations.g);
  const std::uint32_t rows = weak.moves + weak.turns;
  mapping::let_go(weak, equations);
  const Matrix6 h = matrix_of(equations.h);
  const Vector6 g(equations.g);
  // Some rows stand for the same motion: of noisy ones the last keep up to a hundredth of what they had.
  const bool apart = noise_rad == 0.0 || rows == shape.free.size();
  for (std::uint32_t row = 0; row < rows; ++row) {
    const Vector6 z(weak.along[row]);
    const double rounding = 1e-9 * before.norm() * z.squaredNorm();
    CHECK(std::fabs(z.dot(h * z)) <= (apart ? rounding : rounding + 0.01 * z.dot(before * z)));
    if (apart) {
      CHECK((h * z).norm() < 1e-9 * before.norm() * z.norm());
      CHECK(std::fabs(z.dot(g)) < 1e-9 * std::max(g_before.norm(), before.norm() * 0.03) * z.norm());
    }
  }
  CHECK((h - h.transpose()).norm() <= 1e-12 * before.norm());
  // It takes out that and nothing else: what an exact shape holds stays as it was.
  if (noise_rad == 0.0) {
    CHECK((h - before).norm() < 1e-9 * before.norm());
    CHECK((g - g_before).norm() < 1e-9 * std::max(g_before.norm(), before.norm() * 0.03));
  }
  const Vector6 values = testing::eigenvalues_of(h);
  CHECK(values[0] > -1e-9 * before.norm());
  CHECK(values[static_cast<Eigen::Index>(shape.free.size())] > 1e-4 * scale);
}
}  // namespace

TEST_CASE("The weak directions of a shape are those that slide it along itself, however it is turned",
          "[heavy]") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 15; ++run) {
    for (WeakShape& shape : weak_shapes(draws)) {
      const Eigen::Matrix3d r =
          run == 0 ? Eigen::Matrix3d::Identity()
                   : Eigen::AngleAxisd(draws.uniform(-3, 3), drawn_unit(draws)).toRotationMatrix();
      for (auto& [p, n] : shape.points) p = r * p, n = r * n;
      for (Vector6& z : shape.free) z = motion(r * z.head<3>(), r * z.tail<3>());
      judge_weak(shape, std::pow(10.0, draws.uniform(2, 7)), 0.0, draws);
      judge_weak(shape, std::pow(10.0, draws.uniform(2, 7)), 0.003, draws);
    }
  }
}

TEST_CASE("Where nothing was seen every direction is weak, and letting go leaves nothing") {
  mapping::NormalEquations equations;
  const mapping::WeakDirections weak = mapping::weak_directions(equations, 4.0);
  CHECK(weak.moves == 3);
  CHECK(weak.turns == 3);
  mapping::let_go(weak, equations);
  for (int i = 0; i < 6; ++i) {
    CHECK(equations.g[i] == 0.0);
    for (int k = 0; k < 6; ++k) CHECK(equations.h[i][k] == 0.0);
  }
}
