// SPDX-License-Identifier: BSD-3-Clause
// Exact steps and optimal gains, against closed forms, quad precision and a stiff grid.
#include "planner/uav_control/dare.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "planner/uav_control/discretise.hpp"
#include "planner/uav_control/state_gains.hpp"
#include "rt/math.hpp"

namespace {
using namespace sortie;
using planner::Dare;
using planner::DareReport;
using planner::DoubleDouble;
using planner::SmallMatrix;

// The horizontal chain of a multirotor with the weights q on all states.
template <class T>
Dare<T, 6, 1> stiff_chain(double dt_s, double tau_s, double q, double r) {
  SmallMatrix<T, 6, 6> a;
  SmallMatrix<T, 6, 1> b;
  const double couple[5] = {1, 1, 9.81, 1, 1};
  for (std::size_t i = 0; i < 5; ++i) a(i, i + 1) = T(couple[i]);
  a(5, 5) = T(0.0) - T(1.0) / T(tau_s);
  b(5, 0) = T(1.0) / T(tau_s);
  Dare<T, 6, 1> problem;
  REQUIRE(planner::discretise(a, b, dt_s, problem.a, problem.b) == Status::ok);
  for (std::size_t i = 0; i < 6; ++i) problem.q(i, i) = T(q);
  problem.r(0, 0) = T(r);
  return problem;
}

#if defined(__SIZEOF_FLOAT128__) && !defined(__clang__)
#define SORTIE_DARE_QUAD 1
__extension__ typedef __float128 QuadBits;  // NOLINT(modernize-use-using): the extension needs it

// A number in quad precision.
struct DareQuad {
  QuadBits bits{};
  DareQuad() = default;
  DareQuad(double value) : bits(value) {}  // NOLINT(google-explicit-constructor): a number is one
  static DareQuad of(QuadBits value) {
    DareQuad quad;
    quad.bits = value;
    return quad;
  }
  explicit operator double() const { return static_cast<double>(bits); }
  friend DareQuad operator+(const DareQuad& a, const DareQuad& b) { return of(a.bits + b.bits); }
  friend DareQuad operator-(const DareQuad& a, const DareQuad& b) { return of(a.bits - b.bits); }
  friend DareQuad operator*(const DareQuad& a, const DareQuad& b) { return of(a.bits * b.bits); }
  friend DareQuad operator/(const DareQuad& a, const DareQuad& b) { return of(a.bits / b.bits); }
  friend double size_of(const DareQuad& a) { return std::fabs(static_cast<double>(a.bits)); }
};
#endif
}  // namespace

TEST_CASE("Numbers of twice the precision keep what a double loses") {
  const DoubleDouble third = DoubleDouble(1.0) / DoubleDouble(3.0);
  const DoubleDouble rest = DoubleDouble(1.0) - third * DoubleDouble(3.0);
  CHECK(std::fabs(static_cast<double>(rest)) < 1e-31);
  const DoubleDouble big = DoubleDouble(1e16) + DoubleDouble(1.0) - DoubleDouble(1e16);
  CHECK(static_cast<double>(big) == 1.0);
  // (1 + e)^2 = 1 + 2 e + e^2 with e = 2^-40: e^2 is beyond a double.
  const DoubleDouble e(1.0, 0x1p-40);
  const DoubleDouble square = DoubleDouble::exact_product(1.0 + 0x1p-40, 1.0 + 0x1p-40);
  CHECK(square.low == 0x1p-80);
  CHECK(e.low == 0x1p-40);
}

TEST_CASE("The matrix exponential agrees with closed forms, stiff and singular") {
  for (const double t : {1e-3, 0.1, 1.0, 30.0}) {
    SmallMatrix<DoubleDouble, 2, 2> turn;
    turn(0, 1) = DoubleDouble(-t);
    turn(1, 0) = DoubleDouble(t);
    SmallMatrix<DoubleDouble, 2, 2> out;
    REQUIRE(planner::matrix_exponential(turn, out) == Status::ok);
    CHECK(static_cast<double>(out(0, 0)) == Approx(rt::cos(t)).margin(1e-14));
    CHECK(static_cast<double>(out(1, 0)) == Approx(rt::sin(t)).margin(1e-14));
  }
  // A double integrator behind a lag of 0.1 ms in steps of 50 ms: exponent -500, and A is singular.
  SmallMatrix<DoubleDouble, 2, 2> a;
  SmallMatrix<DoubleDouble, 2, 1> b;
  a(0, 1) = DoubleDouble(1.0);
  a(1, 1) = DoubleDouble(-1e4);
  b(1, 0) = DoubleDouble(1e4);
  SmallMatrix<DoubleDouble, 2, 2> ad;
  SmallMatrix<DoubleDouble, 2, 1> bd;
  REQUIRE(planner::discretise(a, b, 0.05, ad, bd) == Status::ok);
  CHECK(static_cast<double>(ad(0, 1)) == Approx(1e-4).epsilon(1e-13));
  CHECK(static_cast<double>(ad(1, 1)) == Approx(rt::exp(-500.0)).epsilon(1e-9));
  CHECK(static_cast<double>(bd(0, 0)) == Approx(0.05 - 1e-4).epsilon(1e-13));
  SmallMatrix<DoubleDouble, 2, 2> bad;
  bad(0, 0) = DoubleDouble(std::nan(""));
  SmallMatrix<DoubleDouble, 2, 2> out;
  CHECK(planner::matrix_exponential(bad, out) == Status::out_of_range);
}

TEST_CASE("Gains of the whole stiff grid: residual, stability, and the same as in quad precision") {
  double worst_residual = 0;
  double worst_gain = 0;
  int cases = 0;
  int most_doublings = 0;
  for (const double dt_s : {1e-3, 0.01, 0.05}) {
    for (const double tau_s : {0.0182, 1e-4, 0.04}) {
      for (const double q : {1e-8, 1.0, 1e8}) {
        for (const double r : {1e-10, 1.0, 1e10}) {
          CAPTURE(dt_s, tau_s, q, r);
          const Dare<DoubleDouble, 6, 1> problem = stiff_chain<DoubleDouble>(dt_s, tau_s, q, r);
          SmallMatrix<DoubleDouble, 1, 6> k;
          DareReport report;
          REQUIRE(problem.solve_gain(k, report) == Status::ok);
          CHECK(report.residual <= 1e-10);
          CHECK(report.stable);
          CHECK(report.radius < 1);
          worst_residual = std::max(worst_residual, report.residual);
          most_doublings = std::max(most_doublings, report.doublings);
          ++cases;
#ifdef SORTIE_DARE_QUAD
          const Dare<DareQuad, 6, 1> twin = stiff_chain<DareQuad>(dt_s, tau_s, q, r);
          SmallMatrix<DareQuad, 6, 6> x;
          SmallMatrix<DareQuad, 1, 6> exact;
          DareReport ignored;
          REQUIRE(twin.doubling(x, ignored) == Status::ok);
          REQUIRE(twin.gain(x, exact) == Status::ok);
          REQUIRE(twin.refine(x, exact) == Status::ok);  // another road to the same X
          REQUIRE(twin.gain(x, exact) == Status::ok);
          for (std::size_t i = 0; i < 6; ++i) {
            const double off = std::fabs(static_cast<double>(k(0, i)) / static_cast<double>(exact(0, i)) - 1);
            worst_gain = std::max(worst_gain, off);
          }
#endif
        }
      }
    }
  }
  CAPTURE(worst_residual, worst_gain, most_doublings);
  CHECK(cases == 81);
  CHECK(worst_gain <= 1e-8);
  CHECK(most_doublings <= 40);
}

TEST_CASE("Refinement leads a solution that was spoilt back, and what cannot be held is refused") {
  const Dare<DoubleDouble, 6, 1> problem = stiff_chain<DoubleDouble>(0.01, 0.0182, 1.0, 1.0);
  SmallMatrix<DoubleDouble, 6, 6> x;
  DareReport report;
  REQUIRE(problem.doubling(x, report) == Status::ok);
  SmallMatrix<DoubleDouble, 1, 6> good;
  REQUIRE(problem.gain(x, good) == Status::ok);
  for (std::size_t i = 0; i < 6; ++i) x(i, i) = x(i, i) * DoubleDouble(1.0 + 1e-5);
  SmallMatrix<DoubleDouble, 1, 6> k;
  REQUIRE(problem.gain(x, k) == Status::ok);
  const double before = problem.residual(x, k);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(problem.refine(x, k) == Status::ok);
    REQUIRE(problem.gain(x, k) == Status::ok);
  }
  CHECK(before > 1e-8);
  CHECK(problem.residual(x, k) < 1e-18);
  for (std::size_t i = 0; i < 6; ++i)
    CHECK(static_cast<double>(k(0, i)) == Approx(static_cast<double>(good(0, i))).epsilon(1e-12));

  Dare<DoubleDouble, 6, 1> hopeless = problem;
  hopeless.b = {};  // no input reaches the integrators
  CHECK(hopeless.solve_gain(k, report) != Status::ok);
}

TEST_CASE("Gains of a vehicle are refused for vehicles that cannot fly") {
  planner::UavModel model;
  planner::StateGains gains;
  CHECK(planner::design_gains(model, 0.01, {}, gains) != Status::ok);
  model.mass_kg = 1.5;
  model.inertia_kg_m2 = {0.03, 0.03, 0.06};
  model.thrust_n_s2 = 1e-5;
  model.moment_m = model.tau_up_s = model.tau_down_s = 0.02;
  model.max_speed_rad_s = 900;
  planner::place_rotors(model, 6, 0.2, 0.5);
  CHECK(planner::design_gains(model, 0.01, {}, gains) == Status::ok);
  CHECK(gains.tilt.position > 0);
  CHECK(planner::design_gains(model, 1.0, {}, gains) == Status::out_of_range);
  model.mass_kg = 50;
  CHECK(planner::design_gains(model, 0.01, {}, gains) == Status::out_of_range);
  model.mass_kg = std::nan("");
  CHECK(planner::design_gains(model, 0.01, {}, gains) == Status::not_finite);
}
