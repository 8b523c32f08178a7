// SPDX-License-Identifier: BSD-3-Clause
// What side views are drawn from: obstacles and the vehicle's outline at some moments, contacts marked.
#include <cmath>

#include "tests/bench/plant/plant_parts.hpp"

namespace sortie::bench {

namespace {

using hil::Vec3;

constexpr double kStep_s = 1e-3;
constexpr int kMoments = 8;
constexpr double kPi = 3.14159265358979323846;

// A closed line in the plane y = 0, seen from the right: x ahead, z up.
class Outline {
 public:
  void add(const Vec3& p) {
    x_.push_back(p.x);
    z_.push_back(p.z);
  }
  Json closed() const {
    Json x = x_;
    Json z = z_;
    x.push_back(x_[0]);
    z.push_back(z_[0]);
    return {{"x", x}, {"z", z}};
  }

 private:
  std::vector<double> x_;
  std::vector<double> z_;
};

// Two wheels and their common tangents: a track or a flipper from `p` to `q`, body axes, brought to the
// world.
Json stadium(const BenchPose& pose, const Vec3& p, double p_radius_m, const Vec3& q, double q_radius_m) {
  Outline outline;
  const double heading = std::atan2(q.z - p.z, q.x - p.x);
  const double open = std::acos((p_radius_m - q_radius_m) / hil::norm(q - p));
  const auto arc = [&](const Vec3& centre, double radius_m, double from, double to) {
    constexpr int kPieces = 12;
    for (int i = 0; i <= kPieces; ++i) {
      const double angle = heading + from + (to - from) * i / kPieces;
      const Vec3 at = centre + radius_m * Vec3{std::cos(angle), 0, std::sin(angle)};
      outline.add(pose.p_world_m + hil::rotate(pose.q_world_body, at));
    }
  };
  arc(p, p_radius_m, open, 2 * kPi - open);
  arc(q, q_radius_m, -open, open);
  return outline.closed();
}

Json box_outline(const rt::convex::Convex& box) {
  // Boxes stand across the way, so that one of their axes is y: the section has the other two.
  Outline outline;
  const double(&m)[9] = box.R_world_body.m;
  for (const auto& [sx, sz] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const double x = sx * box.half_m.x;
    const double z = sz * box.half_m.z;
    outline.add({box.p_world_m.x + m[0] * x + m[2] * z, 0, box.p_world_m.z + m[6] * x + m[8] * z});
  }
  return outline.closed();
}

// The left side of the vehicle, and where it is loaded on either side.
Json moment(const OwnVehicle& vehicle, double t_s) {
  const hil::TrackedPlant& plant = vehicle.plant();
  const hil::VehicleConfig& c = plant.model().config();
  const BenchPose pose = vehicle.pose();
  Json outlines = Json::array();
  const Vec3 half{c.track_half_length_m, 0, 0};
  outlines.push_back(
      stadium(pose, c.track_centre_m - half, c.track_radius_m, c.track_centre_m + half, c.track_radius_m));
  for (const int f : {0, 2}) {
    const double angle = plant.state().flipper_rad[f];
    const Vec3 along{(f < 2 ? 1 : -1) * std::cos(angle), 0, std::sin(angle)};
    const Vec3 pivot = plant.model().pivot(f);
    outlines.push_back(stadium(pose, pivot, c.flipper_large_radius_m, pivot + c.flipper_length_m * along,
                               c.flipper_small_radius_m));
  }
  Json x = Json::array();
  Json z = Json::array();
  for (const hil::ContactPoint& contact : plant.contacts()) {
    if (hil::dot(contact.normal, contact.impulse_ns) <= 0) continue;
    const Vec3 at = pose.p_world_m + hil::rotate(pose.q_world_body, contact.point_m);
    x.push_back(at.x);
    z.push_back(at.z);
  }
  return {{"t_s", t_s}, {"outlines", outlines}, {"contacts", {{"x", x}, {"z", z}}}};
}

Json picture(const BenchScene& scene) {
  OwnVehicle vehicle(scene);
  Json moments = Json::array();
  Json solids = Json::array();
  for (const auto& solid : vehicle.scene().solids()) solids.push_back(box_outline(solid.shape));
  moments.push_back(moment(vehicle, 0));
  const long steps = std::lround(scene.seconds / kStep_s);
  long next = 1;
  drive(vehicle, scene, kStep_s, [&](long step) {
    if (step * (kMoments - 1) < next * steps) return;
    ++next;
    moments.push_back(moment(vehicle, static_cast<double>(step) * kStep_s));
  });
  return {{"scene", scene.name},
          {"about", scene.about},
          {"friction", scene.friction},
          {"solids", solids},
          {"moments", moments}};
}

}  // namespace

void measure_plant_pictures(const PlantSettings& settings, Report& report) {
  Json& pictures = report.root()["pictures"] = Json::array();
  for (const BenchScene* scene : chosen_obstacles(settings)) {
    tell(std::string("picture: ") + scene->name);
    pictures.push_back(picture(*scene));
  }
}

}  // namespace sortie::bench
