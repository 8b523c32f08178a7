// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/stability/kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "estimators/real_rotation.hpp"
#include "estimators/slow_value.hpp"
#include "rt/posix/clock.hpp"
#include "tests/bench/stability/formula_kernels.hpp"

namespace sortie::bench {

namespace {

#if defined(__SIZEOF_FLOAT128__) && !defined(__clang__)
#define SORTIE_KERNEL_QUAD 1
__extension__ typedef __float128 KernelQuad;  // NOLINT(modernize-use-using): the extension needs it
#endif

constexpr std::size_t kInputs = 4096;
constexpr std::uint64_t kKernelSeed = 7;

struct ProductKernel {
  static constexpr const char* kName = "product of two quaternions";
  static constexpr const char* kRuntime = "double, float on small boards";
  static constexpr double kNeed = 1.745e-6;
  static constexpr const char* kWhy = "0.01 degrees after 100 of them";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const auto q = quaternion_at<Real>(in, 0) * quaternion_at<Real>(in, 4);
    return {q.w, q.x, q.y, q.z};
  }
};

struct RotateKernel {
  static constexpr const char* kName = "vector turned by a quaternion";
  static constexpr const char* kRuntime = "double, float on small boards";
  static constexpr double kNeed = 1e-5;
  static constexpr const char* kWhy = "0.1 mm of 10 m";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const auto v = rotate(quaternion_at<Real>(in, 0), vector_at<Real>(in));
    return {v.x, v.y, v.z};
  }
};

struct MatrixKernel {
  static constexpr const char* kName = "quaternion to matrix";
  static constexpr const char* kRuntime = "double, float on small boards";
  static constexpr double kNeed = 1e-5;
  static constexpr const char* kWhy = "0.1 mm of 10 m";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const auto m = matrix_of(quaternion_at<Real>(in, 0));
    return {m.x.x, m.x.y, m.x.z, m.y.x, m.y.y, m.y.z, m.z.x, m.z.y, m.z.z};
  }
};

struct LowPassKernel {
  static constexpr const char* kName = "low-pass, 100 steps of 1/256 s, 3 s";
  static constexpr const char* kRuntime = "double, float on small boards";
  static constexpr double kNeed = 1.7e-4;
  static constexpr const char* kWhy = "0.01 degrees of the inclination";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    estimators::SlowValue<Real> slow;
    const estimators::SlowStep<Real> step(Real(1) / Real(256), Real(4), Real(3));
    for (std::size_t i = 0; i < 100; ++i) slow.take(Real(in[8 + i % 3]) + Real(10), step);
    return {slow.value, slow.slope};
  }
};

struct TurnKernel {
  static constexpr const char* kName = "rotation vector below 0.2 rad to quaternion less one";
  static constexpr const char* kRuntime = "double, float on small boards";
  static constexpr double kNeed = 1e-5;
  static constexpr const char* kWhy = "0.001 % of the turn";
  template <class Real>
  static KernelOutput<Real> run(const KernelInput& in) {
    const auto q = estimators::exp_minus_one(Real(0.0625f) * vector_at<Real>(in));
    return {q.w, q.x, q.y, q.z};
  }
};

#ifdef SORTIE_KERNEL_QUAD
// The same code in quad precision; of the series, whose end would be the same error, Taylor's to the last
// digit.
template <class Kernel>
KernelOutput<KernelQuad> exact(const KernelInput& in) {
  return Kernel::template run<KernelQuad>(in);
}
template <>
KernelOutput<KernelQuad> exact<TurnKernel>(const KernelInput& in) {
  const auto phi = KernelQuad(0.0625f) * vector_at<KernelQuad>(in);
  const KernelQuad u = KernelQuad(0.25) * dot(phi, phi);
  KernelQuad w = 0;
  KernelQuad s = 0;
  KernelQuad even = 1;  // (-u)^k / (2k)!
  for (int k = 0; k < 20; ++k) {
    if (k > 0) w += even;
    s += even / (2 * k + 1);
    even *= -u / ((2 * k + 1) * (2 * k + 2));
  }
  s *= KernelQuad(0.5);
  return {w, s * phi.x, s * phi.y, s * phi.z};
}
#endif

template <class Kernel, class Real>
Json worst_error(const std::vector<KernelInput>& inputs) {
#ifdef SORTIE_KERNEL_QUAD
  double worst = 0;
  for (const KernelInput& in : inputs) {
    const KernelOutput<Real> got = Kernel::template run<Real>(in);
    const KernelOutput<KernelQuad> truth = exact<Kernel>(in);
    double off = 0;
    double size = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
      off = std::max(off, std::fabs(static_cast<double>(KernelQuad(got[i]) - truth[i])));
      size = std::max(size, std::fabs(static_cast<double>(truth[i])));
    }
    worst = std::max(worst, off / size);
  }
  return worst;
#else
  static_cast<void>(inputs);
  return nullptr;
#endif
}

// Best of some rounds: what disturbs only adds.
template <class Kernel, class Real>
double nanoseconds(const std::vector<KernelInput>& inputs) {
  double best = 1e9;
  for (int round = 0; round < 7; ++round) {
    const auto before = rt::posix::thread_cpu_now();
    for (int turn = 0; turn < 10; ++turn) {
      for (const KernelInput& in : inputs) {
        const KernelOutput<Real> out = Kernel::template run<Real>(in);
        __asm__ volatile("" : : "r"(out.data()) : "memory");  // the result is wanted, in memory
      }
    }
    best = std::min(best, static_cast<double>(rt::posix::thread_cpu_now() - before) / (10.0 * kInputs));
  }
  return best;
}

template <class Kernel>
void add_kernel(const std::vector<KernelInput>& inputs, Json& rows) {
  const Json in_float = worst_error<Kernel, float>(inputs);
  const Json in_double = worst_error<Kernel, double>(inputs);
  const char* enough = "not known here";
  if (in_float.is_number()) enough = in_float.get<double>() <= Kernel::kNeed ? "yes" : "no";
  rows.push_back({Kernel::kName, Kernel::kRuntime, in_float, in_double, Kernel::kNeed, Kernel::kWhy, enough,
                  nanoseconds<Kernel, float>(inputs), nanoseconds<Kernel, double>(inputs)});
}

}  // namespace

Json kernel_table() {
  std::mt19937_64 random(kKernelSeed);
  std::vector<KernelInput> inputs(kInputs);
  for (KernelInput& in : inputs) {
    for (float& value : in) value = static_cast<float>(random() % 2'000'001) * 1e-6f - 1.0f;
    for (const std::size_t at : {std::size_t{0}, std::size_t{4}}) {
      float square = 0;
      for (std::size_t i = 0; i < 4; ++i) square += in[at + i] * in[at + i];
      for (std::size_t i = 0; i < 4; ++i) in[at + i] /= std::sqrt(square);
    }
  }
  Json rows = Json::array();
  add_kernel<ProductKernel>(inputs, rows);
  add_kernel<RotateKernel>(inputs, rows);
  add_kernel<MatrixKernel>(inputs, rows);
  add_kernel<LowPassKernel>(inputs, rows);
  add_kernel<TurnKernel>(inputs, rows);
  add_kernel<FarPointKernel>(inputs, rows);
  add_kernel<PathKernel>(inputs, rows);
  add_kernel<TurningCentreKernel>(inputs, rows);
  add_kernel<SupportKernel>(inputs, rows);
  add_kernel<CovarianceKernel>(inputs, rows);
  add_kernel<NormalKernel>(inputs, rows);
  add_kernel<RayWorthKernel>(inputs, rows);
  add_kernel<AttitudeErrorKernel>(inputs, rows);
  add_kernel<GainKernel>(inputs, rows);
  add_kernel<RampKernel>(inputs, rows);
  return {{"group", "kernels"},
          {"columns",
           {"kernel", "in the runtime", "float: error", "double: error", "need", "which is",
            "float is enough", "float, ns", "double, ns"}},
          {"rows", rows}};
}

}  // namespace sortie::bench
