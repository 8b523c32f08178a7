// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/plant/deviation.hpp"

#include <cmath>
#include <map>
#include <string>

#include "tests/bench/plant/plant_parts.hpp"

namespace sortie::bench {

namespace {

constexpr double kFine_s = 0.25e-3;

Path closed_form_path(const BenchScene& scene, const BenchPose& start) {
  const DrivePlan plan(scene);
  Path path;
  for (int k = 1; k <= kSamples; ++k) path.push_back(plan.closed_form(start, scene.seconds * k / kSamples));
  return path;
}

Deviation difference(const Path& path, const Path& reference) {
  Deviation sum;
  for (std::size_t i = 0; i < path.size() && i < reference.size(); ++i) {
    sum.end_d_t = hil::norm(path[i].p_world_m - reference[i].p_world_m);
    sum.end_d_w =
        hil::norm(hil::rotation_vector(hil::conjugate(reference[i].q_world_body) * path[i].q_world_body));
    sum.sum_d_t += sum.end_d_t;
    sum.sum_d_w += sum.end_d_w;
  }
  return sum;
}

}  // namespace

Path sample_drive(BenchVehicle& vehicle, const BenchScene& scene, double dt_s, BenchPose* start) {
  Path path;
  path.reserve(kSamples);
  const long steps = std::lround(scene.seconds / dt_s);
  settle(vehicle, scene, dt_s);
  if (start != nullptr) *start = vehicle.pose();
  const DrivePlan plan(scene);
  for (long i = 0; i < steps; ++i) {
    vehicle.step(plan.belts(static_cast<double>(i) * dt_s, dt_s), dt_s);
    // Sample k at k/100 of the time; the nearest step end, which is exact for all step sizes in use.
    if ((i + 1) * kSamples / steps > i * kSamples / steps) path.push_back(vehicle.pose());
  }
  return path;
}

const Path& fine_path(const BenchScene& scene) {
  static std::map<std::string, Path> known;
  Path& path = known[scene.name];
  if (path.empty()) {
    tell(std::string("reference drive at 0.25 ms: ") + scene.name);
    OwnVehicle vehicle(scene);
    path = sample_drive(vehicle, scene, kFine_s);
  }
  return path;
}

Deviation deviation(const Path& path, const BenchScene& scene, const BenchPose& settled) {
  if (!scene.closed_form) return difference(path, fine_path(scene));
  return difference(path, closed_form_path(scene, scene.settle_s > 0 ? settled : scene.start));
}

Deviation deviation_of(BenchVehicle& vehicle, const BenchScene& scene, double dt_s) {
  BenchPose settled;
  const Path path = sample_drive(vehicle, scene, dt_s, &settled);
  return deviation(path, scene, settled);
}

}  // namespace sortie::bench
