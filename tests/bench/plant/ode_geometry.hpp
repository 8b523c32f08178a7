// SPDX-License-Identifier: BSD-3-Clause
// Solids of our scenes and parts of our vehicle as ODE's geometries. Only for files that are built with ODE.
#pragma once

#if __has_include(<ode/ode.h>) && defined(SORTIE_PEER_ODE)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#include <ode/ode.h>
#pragma GCC diagnostic pop

#include "hil/plant/plant_scene.hpp"
#include "hil/plant/vehicle_config.hpp"
#include "tests/bench/plant/bench_scene.hpp"

namespace sortie::bench {

/// The vehicle in a world. Each geometry's data is its side: +1 left, -1 right, 0 for the box of the body.
struct OdeBody {
  dBodyID body{};
  dSpaceID space{};
  hil::Vec3 com_m;  ///< of the body from the vehicle's origin
};

/// Boxes and half-spaces of a scene; other solids are not in these scenes.
dSpaceID add_ode_obstacles(const hil::PlantScene& scene);

/// One body with masses and inertia of the whole vehicle at the scene's flipper angles, and the outline of
/// the reference model: a box for the body, a box and two cylinders a track, two bars and two cylinders a
/// flipper. At the scene's start, at rest.
OdeBody add_ode_vehicle(dWorldID world, const hil::VehicleConfig& config, const BenchScene& scene);

}  // namespace sortie::bench
#endif
