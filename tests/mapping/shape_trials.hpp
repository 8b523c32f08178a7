// SPDX-License-Identifier: BSD-3-Clause
// Shapes whose free motions are known, looked at by a lidar: what matching names as weak, and whether its
// errors are those that its covariance says.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "mapping/registration/match_covariance.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "tests/mapping/registration_rig.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace sortie::testing {

/// Surfaces that go on beyond the lidar's reach, and the motions of the sensor that change no return.
struct SlidingShape {
  RegistrationWorld world;
  rt::Vector3 sensor;
  std::vector<Eigen::Vector3d> turns;  ///< that are free, a basis
  std::vector<Eigen::Vector3d> moves;  ///< the same of moves, turns giving way
};

enum class ShapeKind { corridor, plane, cylinder, sphere, stairs, two_walls };
inline constexpr ShapeKind kShapeKinds[] = {ShapeKind::corridor, ShapeKind::plane,  ShapeKind::cylinder,
                                            ShapeKind::sphere,   ShapeKind::stairs, ShapeKind::two_walls};
inline const char* name_of(ShapeKind kind) {
  constexpr const char* kNames[] = {"corridor", "plane", "cylinder", "sphere", "stairs", "two walls"};
  return kNames[static_cast<int>(kind)];
}

inline Eigen::Vector3d as_eigen(const rt::Vector3& v) { return {v.x, v.y, v.z}; }
inline rt::Vector3 as_vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Boxes of a world that is turned about z by one angle.
class TurnedBoxes {
 public:
  TurnedBoxes(RegistrationWorld& world, double yaw) : world_(world), yaw_(yaw) {}
  rt::Vector3 turned(const rt::Vector3& v) const { return rt::rotate(rt::exp_rotation({0, 0, yaw_}), v); }
  void add(const rt::Vector3& middle, const rt::Vector3& half) {
    world_.boxes.push_back({turned(middle), half, yaw_});
  }

 private:
  RegistrationWorld& world_;
  double yaw_;
};

/// Off the middle of something round by nothing or by so much that it shows: `free` turns about `at`.
inline void add_round(SlidingShape& shape, const rt::Vector3& at, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d swing = axis.cross(as_eigen(shape.sensor - at));
  shape.turns.push_back(axis);
  if (swing.norm() > 1e-9) shape.moves.push_back(swing);
}

inline SlidingShape drawn_shape(ShapeKind kind, Draws& draws) {
  constexpr double kFar = 300.0;
  SlidingShape shape;
  TurnedBoxes boxes(shape.world, draws.uniform(0, M_PI));
  const auto along = [&boxes](double x, double y, double z) { return as_eigen(boxes.turned({x, y, z})); };
  shape.sensor = {draws.uniform(-20, 20), draws.uniform(-20, 20), draws.uniform(-2, 2)};
  const rt::Vector3 p = shape.sensor;
  // Boxes are given relative to the sensor, along the shape's own axes.
  const auto box = [&](const rt::Vector3& middle, const rt::Vector3& half) {
    boxes.add(middle, half);
    shape.world.boxes.back().middle = shape.world.boxes.back().middle + p;
  };
  const double low = draws.uniform(0.4, 1.0);
  switch (kind) {
    case ShapeKind::corridor:
      box({0, -draws.uniform(0.8, 2) - 1, 0}, {kFar, 1, kFar});
      box({0, draws.uniform(0.8, 2) + 1, 0}, {kFar, 1, kFar});
      box({0, 0, -low - 1}, {kFar, kFar, 1});
      shape.moves = {along(1, 0, 0)};
      break;
    case ShapeKind::plane:
      box({0, 0, -low - 1}, {kFar, kFar, 1});
      shape.moves = {along(1, 0, 0), along(0, 1, 0)};
      shape.turns = {along(0, 0, 1)};
      break;
    case ShapeKind::two_walls:
      box({draws.uniform(1, 5) + 1, 0, 0}, {1, kFar, kFar});
      box({0, draws.uniform(1, 5) + 1, 0}, {kFar, 1, kFar});
      shape.moves = {along(0, 0, 1)};
      break;
    case ShapeKind::stairs: {
      const double tread = draws.uniform(0.25, 0.35);
      const double rise = draws.uniform(0.14, 0.2);
      for (int i = 0; i < 14; ++i) box({0.6 + tread * i + 20, 0, -low - 1 + rise * (i + 1)}, {20, kFar, 1});
      box({-20, 0, -low - 1}, {kFar, kFar, 1});
      shape.moves = {along(0, 1, 0)};
      break;
    }
    case ShapeKind::cylinder:
    case ShapeKind::sphere: {
      const double radius = draws.uniform(1.2, 4);
      const rt::Vector3 axis = draws.direction();
      const rt::Vector3 aside = rt::cross(axis, draws.direction());
      const double off = draws.uniform(0, 1) < 0.5 ? 0.0 : radius * draws.uniform(0.3, 0.6);
      const rt::Vector3 at = p + (off / rt::norm(aside)) * aside;
      if (kind == ShapeKind::sphere) {
        shape.world.balls.push_back({at, radius});
        for (const Eigen::Vector3d& unit :
             {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)})
          add_round(shape, at, unit);
      } else {
        shape.world.columns.push_back({at, axis, radius});
        shape.moves = {as_eigen(axis)};
        add_round(shape, at, as_eigen(axis));
      }
      break;
    }
  }
  return shape;
}

/// Projector onto the span of vectors, and its rank.
struct SpanOf {
  int rank{};
  Eigen::Matrix3d onto = Eigen::Matrix3d::Zero();

  explicit SpanOf(const std::vector<Eigen::Vector3d>& vectors) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& v : vectors) sum += v * v.transpose();
    const Eigen3 eigen = eigen_of(sum);
    for (int i = 0; i < 3; ++i) {
      if (eigen.values[i] < 1e-9) continue;
      ++rank;
      onto += eigen.vectors.col(i) * eigen.vectors.col(i).transpose();
    }
  }
  /// Of `units`: how many lie in this span to 10 degrees.
  int holds(const std::vector<Eigen::Vector3d>& units) const {
    return static_cast<int>(std::count_if(units.begin(), units.end(), [this](const Eigen::Vector3d& v) {
      return (onto * v).norm() > 0.985 * v.norm();
    }));
  }
  std::vector<Eigen::Vector3d> basis() const {
    const Eigen3 eigen = eigen_of(onto);
    std::vector<Eigen::Vector3d> out;
    for (int i = 3 - rank; i < 3; ++i) out.emplace_back(eigen.vectors.col(i));
    return out;
  }
};

/// Directions named and true, over some trials.
struct NamedDirections {
  int named{};
  int named_right{};
  int real{};
  int real_found{};
  double precision() const { return named > 0 ? named_right / static_cast<double>(named) : 1.0; }
  double recall() const { return real > 0 ? real_found / static_cast<double>(real) : 1.0; }

  void take(const std::vector<Eigen::Vector3d>& found, const std::vector<Eigen::Vector3d>& free) {
    const SpanOf all_found(found), all_free(free);
    named += static_cast<int>(found.size());
    named_right += all_free.holds(found);
    const std::vector<Eigen::Vector3d> basis = all_free.basis();
    real += static_cast<int>(basis.size());
    real_found += all_found.holds(basis);
  }
};

/// What trials of one kind gave.
struct ShapeTally {
  NamedDirections moves, turns;
  int trials{};
  double nees{};  ///< sum over the trials, 6 unknowns each
  int refused{};  ///< no covariance
};

/// Map of six scans about the sensor's place, a further scan matched to it from a start that the prior knows.
inline void try_shape(ShapeKind kind, std::uint64_t seed, ShapeTally& tally) {
  Draws draws(seed);
  const SlidingShape shape = drawn_shape(kind, draws);
  TestLidar lidar;
  lidar.noise_m = draws.uniform(0.005, 0.02);
  mapping::RegistrationConfig config;
  OwnedRegistration owned(config);
  const auto pose_about = [&draws, &shape](double move_m, double turn_rad) {
    return mapping::RigidPose{shape.sensor + draws.uniform(0, move_m) * draws.direction(),
                              rt::exp_rotation(draws.uniform(0, turn_rad) * draws.direction())};
  };
  for (int i = 0; i < 6; ++i) {
    const mapping::RigidPose pose = pose_about(0.3, 0.3);
    owned.part.take(lidar.scan(shape.world, pose.p, pose.q, draws));
    owned.part.insert(pose);
  }
  const mapping::RigidPose truth{shape.sensor, rt::exp_rotation(draws.uniform(0, 0.3) * draws.direction())};
  owned.part.take(lidar.scan(shape.world, truth.p, truth.q, draws));
  constexpr double kMove = 0.05, kTurn = 0.02;
  mapping::PosePrior prior;
  prior.at = {
      truth.p + rt::Vector3{kMove * draws.normal(), kMove * draws.normal(), kMove * draws.normal()},
      rt::exp_rotation({kTurn * draws.normal(), kTurn * draws.normal(), kTurn * draws.normal()}) * truth.q};
  for (int i = 0; i < 3; ++i) {
    prior.information[i][i] = 1 / (kTurn * kTurn);
    prior.information[3 + i][3 + i] = 1 / (kMove * kMove);
  }
  const mapping::Match match = owned.part.match(prior.at, prior.at, prior, 0.0);
  std::vector<Eigen::Vector3d> moves, turns;
  for (std::uint32_t i = 0; i < match.weak.moves; ++i) moves.push_back(as_eigen(match.weak.move[i]));
  for (std::uint32_t i = 0; i < match.weak.turns; ++i) turns.push_back(as_eigen(match.weak.turn[i]));
  tally.moves.take(moves, shape.moves);
  tally.turns.take(turns, shape.turns);
  ++tally.trials;
  double c[6][6];
  if (!mapping::match_covariance(match.equations, match.weak, prior, match.spread, c)) {
    ++tally.refused;
    return;
  }
  Matrix6 covariance;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) covariance(i, k) = c[i][k];
  }
  Vector6 error;
  error << as_eigen(rt::log_rotation(match.pose.q * rt::conjugate(truth.q))),
      as_eigen(match.pose.p - truth.p);
  tally.nees += error.dot(solved(covariance, error));
}

}  // namespace sortie::testing
