// SPDX-License-Identifier: BSD-3-Clause
// One step of matching a scan to surfels: the scan is summed up cell by cell, each cell gives one residual
// along the normal of its surface, and the pose goes where the sum of their squares is least.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/registration/scan_sample.hpp"
#include "mapping/registration/surfel_layer.hpp"

namespace sortie::mapping {

/// A quadratic about a pose: unknowns are a turn w about the sensor (rad) and a move u (m), both along the
/// map's axes, x' = exp(w) (x - p) + p + u. The minimum is where h (w, u) = -g.
struct NormalEquations {
  double h[6][6]{};
  double g[6]{};
  double squares{};  ///< weighted sum of squared residuals
  /// Where it was asked for: h with the lever of each cell at the map's mean there, whose normal it is. To
  /// the scan's own mean a round surface would seem to hold turns that slide it along itself.
  double held[6][6]{};
  double noise[6][6]{};  ///< what `held` would be were the normals' noise all that is in it
  std::uint32_t rows{};  ///< residuals, one a cell that has a normal
  bool planar{};         ///< x, y and the turn about z are unknown; the others are held, and their sums are 0

  /// Whether unknown `i` of (turn, move) is held.
  bool holds(int i) const { return planar && (i < 2 || i == 5); }
};

/// What a pose is believed to be before the scan: its own residual, about `at`.
struct PosePrior {
  RigidPose at;
  double information[6][6]{};  ///< of (turn, move) as in NormalEquations; all 0: nothing is known
};

/// Robustness of a step.
struct StepRule {
  double scale_m{0.1};  ///< of Geman-McClure: residuals beyond it hardly count
  double sigma_m{0.02};
  bool noise{false};      ///< NormalEquations::held and noise are wanted: 108 sums more a cell
  bool confirmed{false};  ///< of cells alone whose surface goes on in a neighbour
};

/// A scan's sums in one cell, on their way.
struct CellSums {
  SurfelSums sums;
  SurfelCell cell;
  SurfelIndex surfel{kNoSurfel};
};

/// Scratch of a step, for any layer of at most `slots.size()` surfels.
struct StepMemory {
  struct Slot {
    std::uint32_t stamp{};
    std::uint32_t at{};
  };
  std::span<Slot> slots;      ///< as many as the largest layer has surfels
  std::span<CellSums> cells;  ///< as many as a sample has returns
};

/// Sums up scans and solves; holds nothing between calls but scratch.
class ScanStep {
 public:
  /// `planar`: see NormalEquations.
  explicit ScanStep(const StepMemory& memory, bool planar = false) : memory_(memory), planar_(planar) {}

  /// The equations of a sample at a pose. Cost: a look-up a return, 27 sums a cell.
  NormalEquations equations(const SurfelLayer& layer, std::span<const SamplePoint> sample,
                            const RigidPose& pose, const StepRule& rule);
  /// Equations with the prior, solved and applied. False where nothing holds the pose: it stays.
  static bool advance(const NormalEquations& equations, const PosePrior& prior, RigidPose& pose);

 private:
  std::uint32_t sum_up(const SurfelLayer& layer, std::span<const SamplePoint> sample, const RigidPose& pose);

  StepMemory memory_;
  bool planar_;
  std::uint32_t stamp_{};
};

/// Solves a x = b for a symmetric, positive definite 6x6 a by Cholesky. False where it is not.
bool solve6(const double (&a)[6][6], const double (&b)[6], double (&x)[6]);

}  // namespace sortie::mapping
