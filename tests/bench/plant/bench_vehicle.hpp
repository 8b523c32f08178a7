// SPDX-License-Identifier: BSD-3-Clause
// One vehicle on one scene, whoever computes it: ours, or the peer's engine.
#pragma once

#include <cstdint>
#include <memory>

#include "hil/plant/tracked_plant.hpp"
#include "tests/bench/plant/bench_scene.hpp"
#include "tests/bench/plant/drive_plan.hpp"

namespace sortie::bench {

/// A vehicle that is stepped.
class BenchVehicle {
 public:
  virtual ~BenchVehicle() = default;
  /// Advances with these mean belt speeds.
  virtual void step(const BeltSpeeds& belts, double dt_s) = 0;
  virtual BenchPose pose() const = 0;
  /// Deepest that a contact ever was, m.
  virtual double deepest_m() const = 0;
};

/// Our plant on a scene.
class OwnVehicle : public BenchVehicle {
 public:
  /// The scene's settings; `newton_iterations` is the solver's knob.
  explicit OwnVehicle(const BenchScene& scene, int newton_iterations = hil::PlantConfig{}.newton_iterations);

  void step(const BeltSpeeds& belts, double dt_s) override;
  BenchPose pose() const override;
  double deepest_m() const override { return plant_->counters().penetration_m; }
  const hil::TrackedPlant& plant() const { return *plant_; }
  const hil::PlantScene& scene() const { return *scene_; }

 private:
  std::unique_ptr<hil::PlantScene> scene_;
  std::unique_ptr<hil::TrackedPlant> plant_;
  hil::PlantCommand command_;
};

/// The peer's solvers.
enum class OdeSolver : unsigned char {
  quick,    ///< dWorldQuickStep, 20 iterations
  dantzig,  ///< dWorldStep
};

/// True where this program was built with ODE.
bool has_ode();

/// Messages of its own faults that ODE would have printed since the program began.
std::uint64_t ode_complaints();

/// The same vehicle and scene in ODE; null where has_ode() is false.
std::unique_ptr<BenchVehicle> make_ode_vehicle(const BenchScene& scene, OdeSolver solver);

}  // namespace sortie::bench
