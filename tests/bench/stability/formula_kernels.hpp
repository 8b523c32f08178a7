// SPDX-License-Identifier: BSD-3-Clause
// Kernels whose code in the runtime has one precision. Each formula is written once more for any precision;
// where the runtime's own function takes plain numbers it is what runs in its precision, so that it is
// judged, not the twin.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "estimators/real_rotation.hpp"
#include "mapping/grid/plane_batch.hpp"
#include "planner/icr_model.hpp"

namespace sortie::bench {

/// Two unit quaternions and three numbers in [-1, 1]; all exact in float.
using KernelInput = std::array<float, 11>;
/// What a kernel gives; unused places are 0.
template <class Real>
using KernelOutput = std::array<Real, 9>;

template <class Real>
estimators::QuaternionOf<Real> quaternion_at(const KernelInput& in, std::size_t at) {
  return {Real(in[at]), Real(in[at + 1]), Real(in[at + 2]), Real(in[at + 3])};
}
template <class Real>
estimators::VectorOf<Real> vector_at(const KernelInput& in) {
  return {Real(in[8]), Real(in[9]), Real(in[10])};
}

/// A sensor's point in a world whose origin is 10 km away.
struct FarPointKernel {
  static constexpr const char* kName = "point within 50 m to a world 10 km away";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 1e-7;
  static constexpr const char* kWhy = "1 mm of 10 km";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const auto p = rotate(quaternion_at<Real>(in, 0), Real(50) * vector_at<Real>(in));
    return {Real(10000) * Real(in[4]) + p.x, Real(10000) * Real(in[5]) + p.y,
            Real(10000) * Real(in[6]) + p.z};
  }
};

/// Dead reckoning: a hundred steps of 2 cm and up to 3 degrees.
struct PathKernel {
  static constexpr const char* kName = "100 motions of 2 cm put together";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 5e-5;
  static constexpr const char* kWhy = "0.1 mm of 2 m";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    auto q = quaternion_at<Real>(in, 0);
    const auto turn = estimators::exp_minus_one(Real(0.03f) * vector_at<Real>(in));
    estimators::VectorOf<Real> p{};
    for (int i = 0; i < 100; ++i) {
      p = p + rotate(q, {Real(0.02f), Real(0), Real(0)});
      const auto change = q * turn;
      q = {q.w + change.w, q.x + change.x, q.y + change.y, q.z + change.z};
      const Real shrink = Real(1.5) - Real(0.5) * (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
      q = {shrink * q.w, shrink * q.x, shrink * q.y, shrink * q.z};
    }
    return {p.x, p.y, p.z};
  }
};

/// Speed and turn rate of a skid-steered body (Martinez et al. 2005).
struct TurningCentreKernel {
  static constexpr const char* kName = "belt speeds to speed and turn rate";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 1e-3;
  static constexpr const char* kWhy = "1 mm/s of 1 m/s";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const Real l = Real(in[8]), r = Real(in[9]);
    const Real y_left = Real(0.3f) + Real(0.1f) * Real(in[10]), y_right = Real(-0.3f);
    const Real span = y_left - y_right;
    return {(r * y_left - l * y_right) / span, (r - l) / span};
  }
};
template <>
inline KernelOutput<double> TurningCentreKernel::run<double>(const KernelInput& in) {
  const double y_left = static_cast<double>(0.3f) + static_cast<double>(0.1f) * static_cast<double>(in[10]);
  const planner::IcrModel model{0, y_left, static_cast<double>(-0.3f)};
  const planner::Twist twist = model.to_twist({static_cast<double>(in[8]), static_cast<double>(in[9])});
  return {twist.v_x_m_s, twist.w_rad_s};
}

/// h(d) = max of r - x sin d - z cos d over wheels and flipper tips: how high the origin is over what carries
/// it.
struct SupportKernel {
  static constexpr const char* kName = "height over the carrying plane, four discs";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 5e-3;
  static constexpr const char* kWhy = "0.5 mm of 10 cm";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    // A unit quaternion about one axis has cosine and sine of an angle in it.
    const Real c = Real(in[0]), s = Real(in[1]), l = Real(0.33f);
    const std::array<std::array<Real, 3>, 4> discs{
        {{Real(0.25f), Real(0), Real(0.078f)},
         {Real(-0.25f), Real(0), Real(0.078f)},
         {Real(0.25f) + l * Real(in[2]), l * Real(in[3]), Real(0.029f)},
         {Real(-0.25f) - l * Real(in[2]), l * Real(in[3]), Real(0.029f)}}};
    Real height = Real(-1);
    for (const auto& disc : discs) height = std::max(height, disc[2] - disc[0] * s - disc[1] * c);
    return {height};
  }
};

/// The error of an attitude in a controller: half of what is skew in Rd' R, both apart by up to 0.02 rad.
struct AttitudeErrorKernel {
  static constexpr const char* kName = "attitude's error below 0.02 rad";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 1e-2;
  static constexpr const char* kWhy = "1 % of the correction";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const auto wanted = quaternion_at<Real>(in, 0);
    const auto turn = estimators::exp_minus_one(Real(0.015625f) * vector_at<Real>(in));
    const auto change = wanted * turn;
    const auto m = matrix_of(wanted);
    const auto is = matrix_of(estimators::QuaternionOf<Real>{wanted.w + change.w, wanted.x + change.x,
                                                             wanted.y + change.y, wanted.z + change.z});
    const auto column = [](const estimators::MatrixOf<Real>& a, int i) {
      return i == 0   ? estimators::VectorOf<Real>{a.x.x, a.y.x, a.z.x}
             : i == 1 ? estimators::VectorOf<Real>{a.x.y, a.y.y, a.z.y}
                      : estimators::VectorOf<Real>{a.x.z, a.y.z, a.z.z};
    };
    const auto skew = [&](int i, int k) {
      return Real(0.5) * (dot(column(m, i), column(is, k)) - dot(column(m, k), column(is, i)));
    };
    return {skew(2, 1), skew(0, 2), skew(1, 0)};
  }
};

/// A place on a ramp with bounded jerk, 8 s after its start.
struct RampKernel {
  static constexpr const char* kName = "place on a ramp after 8 s";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 1e-5;
  static constexpr const char* kWhy = "1 mm of 100 m";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const Real t = Real(8) + Real(in[4]);
    const Real p = Real(100) * Real(in[5]), v = Real(5) * Real(in[8]), a = Real(in[9]), j = Real(in[10]);
    return {p + t * (v + t * (a / Real(2) + t * (j / Real(6)))), Real(100)};
  }
};

/// Worth of a ray through 64 cells: sum of p_k F_{k-1} (e_1 + ... + e_k), with probabilities from 1e-6 on.
struct RayWorthKernel {
  static constexpr const char* kName = "worth of a ray through 64 cells";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 1e-3;
  static constexpr const char* kWhy = "0.1 % of the worth";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    Real free = Real(1), seen = Real(0), worth = Real(0);
    for (std::size_t k = 0; k < 64; ++k) {
      const Real x = Real(in[k % 11]);
      const Real square = x * x * x * x;
      const Real occupied = Real(1e-6f) + Real(0.25f) * square * square;
      seen = seen + Real(0.0625f) * (x + Real(1));
      worth = worth + occupied * free * seen;
      free = free * (Real(1) - occupied);
    }
    return {worth};
  }
};

/// What is left of a covariance after 100 steps P <- F P F' + Q.
struct CovarianceKernel {
  static constexpr const char* kName = "covariance of place and speed, 100 steps";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 1e-2;
  static constexpr const char* kWhy = "1 % of the variance";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const Real dt = Real(0.0078125f);
    Real pp = Real(0.01f) + Real(0.005f) * Real(in[8]), pv = Real(0),
         vv = Real(0.04f) + Real(0.02f) * Real(in[9]);
    const Real noise = dt * (Real(0.01f) + Real(0.005f) * Real(in[10]));
    for (int i = 0; i < 100; ++i) {
      pp = pp + dt * (Real(2) * pv + dt * vv);
      pv = pv + dt * vv;
      vv = vv + noise;
    }
    return {pp, pv, vv};
  }
};

/// Gains times a state of eight, of unlike size.
struct GainKernel {
  static constexpr const char* kName = "gains times a state of eight";
  static constexpr const char* kRuntime = "double";
  static constexpr double kNeed = 1e-3;
  static constexpr const char* kWhy = "0.1 % of the command";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    constexpr std::array<float, 8> kGains{14.0f, 55.0f, 96.0f, 88.0f, 31.0f, 6.5f, 0.4f, 0.03f};
    Real sum = Real(0), size = Real(0);
    for (std::size_t i = 0; i < 8; ++i) {
      const Real part = Real(kGains[i]) * Real(in[i]);
      sum = sum + part;
      size = size + (part < Real(0) ? -part : part);
    }
    return {sum, size};
  }
};

/// Normal of a plane from its covariance: smallest eigenvalue by Newton's method, longest of three cross
/// products.
struct NormalKernel {
  static constexpr const char* kName = "normal of a flat voxel";
  static constexpr const char* kRuntime = "float";
  static constexpr double kNeed = 1.745e-3;
  static constexpr const char* kWhy = "0.1 degrees";

  // A covariance of whole numbers, as the map has them: a plane that is turned, some thickness.
  template <class Real>
  static std::array<Real, 6> covariance(const KernelInput& in) {
    const auto m = matrix_of(quaternion_at<double>(in, 0));
    std::array<double, 6> sums{};
    for (int i = 0; i < 12; ++i) {
      const double a = 400.0 * static_cast<double>(in[static_cast<std::size_t>(i % 7)]);
      const double b =
          400.0 * static_cast<double>(in[static_cast<std::size_t>(10 - i % 11)]) * (i % 2 == 0 ? 1 : -1);
      const rt::Vector3 at = widened(m * estimators::VectorOf<double>{a, b, i % 3 - 1.0});
      const double x = std::floor(at.x), y = std::floor(at.y), z = std::floor(at.z);
      const std::array<double, 6> part{x * x, y * y, z * z, x * y, x * z, y * z};
      for (std::size_t k = 0; k < 6; ++k) sums[k] += part[k];
    }
    std::array<Real, 6> out{};
    for (std::size_t k = 0; k < 6; ++k) out[k] = static_cast<Real>(sums[k]);
    return out;
  }

  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    using Vector = estimators::VectorOf<Real>;
    std::array<Real, 6> s = covariance<Real>(in);
    const Real share = Real(1) / (s[0] + s[1] + s[2]);
    for (Real& value : s) value = share * value;
    const Real c2 = s[0] * s[1] + s[0] * s[2] + s[1] * s[2] - s[3] * s[3] - s[4] * s[4] - s[5] * s[5];
    const Real c3 = s[0] * (s[1] * s[2] - s[5] * s[5]) - s[3] * (s[3] * s[2] - s[5] * s[4]) +
                    s[4] * (s[3] * s[5] - s[1] * s[4]);
    Real least = Real(0);  // of x^3 - x^2 + c2 x - c3, from below
    for (int i = 0; i < 12; ++i) {
      const Real value = ((least - Real(1)) * least + c2) * least - c3;
      least = least - value / ((Real(3) * least - Real(2)) * least + c2);
    }
    const Vector x{s[0] - least, s[3], s[4]}, y{s[3], s[1] - least, s[5]}, z{s[4], s[5], s[2] - least};
    Vector best{};
    Real longest = Real(0);
    for (const Vector& n : {cross(x, y), cross(x, z), cross(y, z)}) {
      const Real square = dot(n, n);
      if (square > longest) {
        longest = square;
        best = n;
      }
    }
    // Without a root: scaled so that its largest coordinate is one.
    const auto size = [](Real v) { return v < Real(0) ? -v : v; };
    Real most = best.z;
    if (size(best.y) > size(most)) most = best.y;
    if (size(best.x) > size(most)) most = best.x;
    return {best.x / most, best.y / most, best.z / most};
  }
};
template <>
inline KernelOutput<float> NormalKernel::run<float>(const KernelInput& in) {
  const std::array<double, 6> s = covariance<double>(in);
  mapping::PlaneBatch batch;
  batch.add({s[0], s[1], s[2], s[3], s[4], s[5]});
  batch.solve();
  const std::array<float, 3> n{batch.normal(0, 0), batch.normal(1, 0), batch.normal(2, 0)};
  float most = n[2];
  for (const float value : {n[1], n[0]}) most = std::abs(value) > std::abs(most) ? value : most;
  return {n[0] / most, n[1] / most, n[2] / most};
}

}  // namespace sortie::bench
