// SPDX-License-Identifier: BSD-3-Clause
// Proofs of the tracked plant over whole drives: against the dense solver, its mirror image, other step
// sizes.
#pragma once

#include "plant_scenes.hpp"
#include "tests/hil/judge/natural_residual.hpp"
#include "tests/hil/judge/reference_solver.hpp"

namespace sortie::hil {

/// What the dense solver left in the drive under way, as a share of m g dt.
inline double& dense_residual_share() {
  static double worst = 0.0;
  return worst;
}

/// The dense solver in the plant's place for one. The tolerance of a plant at rest is 1e-7 m g dt.
inline SolverReport solve_densely(ContactProblem& problem, Generalised& velocity,
                                  const SolverOptions& options) {
  const ReferenceReport found = solve_reference(problem, velocity, 1e-2 * options.tolerance_ns);
  dense_residual_share() = std::max(dense_residual_share(), 1e-7 * found.residual_ns / options.tolerance_ns);
  SolverReport report;
  report.residual_ns = found.residual_ns;
  report.converged = found.residual_ns <= options.tolerance_ns;
  return report;
}

/// True where friction 5 % less or more moves the end by more than 2 cm: what a solver or a step size does
/// there says little about it.
inline bool is_marginal(const ProvingDrive& drive, ProvingWay way) {
  const Vec3 end = end_of(drive, way);
  double most = 0.0;
  for (const double factor : {0.95, 1.05}) {
    way.friction_factor = factor;
    most = std::max(most, norm(end_of(drive, way) - end));
  }
  return most > 0.02;
}

/// What a drive and the same one with the dense solver say; residuals as shares of m g dt, the worst step's.
struct DenseProof {
  double residual{};
  double dense_residual{};
  double ends_apart_m{};
};

inline DenseProof prove_against_dense(const ProvingDrive& drive, ProvingWay way) {
  CAPTURE(drive.name, way.dt_s, static_cast<int>(way.mode));
  PlantBench fast = proving_bench(drive, way);
  const double weight_ns = fast.plant->model().mass_kg() * 9.81 * way.dt_s;
  double worst = 0.0;
  const Vec3 end = prove(fast, drive, way, [&] {
    const ContactProblem& problem = fast.plant->problem();
    worst = std::max(worst, natural_residual(problem, problem.compliance));
  });
  dense_residual_share() = 0.0;
  way.solver = solve_densely;
  const Vec3 judged = end_of(drive, way);
  return {worst / weight_ns, dense_residual_share(), norm(end - judged)};
}

inline void check(const DenseProof& proof) {
  CHECK(proof.residual <= 1e-4);
  CHECK(proof.dense_residual > 0.0);  // or the dense solver was never asked
  CHECK(proof.dense_residual <= 1e-9);
  CHECK(proof.ends_apart_m <= 1e-3);
}

/// Belts that are at full speed at once slip on the first edge that they meet, and where they slip a step's
/// problem may have several answers: rounding chooses one, and paths part by up to 3 mm.
constexpr double kMirrorRamp_s = 0.3;

inline void prove_mirror_image(const ProvingDrive& drive, ProvingWay way) {
  CAPTURE(drive.name, way.dt_s, static_cast<int>(way.mode));
  PlantBench one = proving_bench(drive, way);
  way.mirrored = true;
  PlantBench other = proving_bench(drive, way);
  const bool plane = one.scene->solids().empty();
  const double left = drive.left_m_s;
  const double right = drive.right_m_s;
  double worst = 0.0;
  const long steps = std::lround(drive.seconds / way.dt_s);
  for (long i = 1; i <= steps; ++i) {
    const double share = std::min(1.0, static_cast<double>(i) * way.dt_s / kMirrorRamp_s);
    one.step(share * left, share * right);
    other.step(share * right, share * left);
    const Vec3 image = other.position();
    worst = std::max(worst, norm(one.position() - Vec3{image.x, -image.y, image.z}));
  }
  INFO("largest difference " << worst);
  CHECK(worst < (plane ? 1e-9 : 1e-3));
}

/// How far the ends at 1 ms and at 5 ms are apart, m.
inline double prove_step_size(const ProvingDrive& drive, ProvingWay way) {
  way.dt_s = 1e-3;
  const Vec3 fine = end_of(drive, way);
  way.dt_s = 5e-3;
  const Vec3 coarse = end_of(drive, way);
  return norm(fine - coarse);
}

}  // namespace sortie::hil
