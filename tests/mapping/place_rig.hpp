// SPDX-License-Identifier: BSD-3-Clause
// A relocaliser on a map of a made-up building, with memory of its own.
#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "mapping/registration/relocaliser.hpp"
#include "tests/mapping/place_worlds.hpp"

namespace sortie::testing {

/// Room for a site of 127 x 127 x 15 m, or for one hall.
inline constexpr mapping::RegistrationMemory kSiteMemory{100'000, 512, 64};
inline constexpr mapping::RegistrationMemory kHallMemory{32'768, 128, 64};

struct PlaceRig {
  std::size_t size;
  std::unique_ptr<std::byte[]> bytes;
  rt::Arena arena;
  mapping::ScanRegistration registration;
  mapping::Relocaliser part;

  explicit PlaceRig(const mapping::RegistrationMemory& memory, const mapping::RelocateConfig& config = {},
                    const mapping::PlaceSearchConfig& search = {})
      : size(std::size_t{memory.window_cells > 128 ? 200u : 50u} << 20),
        bytes(new std::byte[size]),
        arena({bytes.get(), size}),
        registration({}, arena, memory),
        part(config, search, memory, registration, arena) {}

  void add(const std::vector<rt::ScanPoint>& scan, const mapping::RigidPose& pose) {
    registration.take(scan);
    registration.insert(pose);
  }
  /// A map as a robot that went everywhere makes it: a scan about every `spacing` metres.
  void make_map(const PlaceWorld& world, Draws& draws, double spacing) {
    for (mapping::SurfelLayer* layer :
         {&registration.layer_to_load(0), &registration.layer_to_load(1), &registration.layer_to_load(2)})
      layer->clear();
    const TestLidar lidar{32, 720, -0.7, 0.7};
    for (const double floor : world.floors) {
      for (double y = 0.5 * spacing; y < world.deep; y += spacing) {
        for (double x = 0.5 * spacing; x < world.wide; x += spacing) {
          for (int tries = 0; tries < 20; ++tries) {
            const rt::Vector3 p{x + draws.uniform(-0.4, 0.4) * spacing,
                                y + draws.uniform(-0.4, 0.4) * spacing, floor + 0.8};
            if (!world.is_free(p, 0.4)) continue;
            const rt::Quaternion q = rt::exp_rotation({0, 0, draws.uniform(-3, 3)});
            add(place_scan(lidar, world, p, q, draws), {p, q});
            break;
          }
        }
      }
    }
    if (!part.take_map()) throw std::runtime_error("a relocaliser has no room for the map");
  }
  /// One search from a scan; in jobs of `budget` units.
  const mapping::Relocated& find(const std::vector<rt::ScanPoint>& scan, const rt::Quaternion& q_level_sensor,
                                 std::uint64_t budget = ~std::uint64_t{0} >> 1) {
    registration.take(scan);
    part.begin(registration.sample(), q_level_sensor);
    for (std::uint64_t units = budget; !part.run(units); units = budget) {
    }
    return part.result();
  }
};

/// A robot somewhere, tilted by up to 5 degrees, and what it knows of its attitude: to half a degree.
struct LostRobot {
  mapping::RigidPose pose;
  rt::Quaternion q_level_sensor;

  LostRobot(const PlaceWorld& world, Draws& draws) {
    pose.p = free_place(world, draws);
    const rt::Quaternion tilt = rt::exp_rotation({draws.uniform(-0.08, 0.08), draws.uniform(-0.08, 0.08), 0});
    pose.q = rt::normalised(rt::exp_rotation({0, 0, draws.uniform(-M_PI, M_PI)}) * tilt);
    const rt::Quaternion error = rt::exp_rotation({0.006 * draws.normal(), 0.006 * draws.normal(), 0});
    q_level_sensor = rt::normalised(error * rt::exp_rotation({0, 0, draws.uniform(-M_PI, M_PI)}) * pose.q);
  }
  double move_m(const mapping::RigidPose& other) const { return rt::norm(pose.p - other.p); }
  double turn_rad(const mapping::RigidPose& other) const {
    return rt::norm(rt::log_rotation(pose.q * rt::conjugate(other.q)));
  }
  /// Within 10 cm and 1 degree.
  bool is_right(const mapping::RigidPose& other) const {
    return move_m(other) < 0.1 && turn_rad(other) < 0.01745;
  }
};

}  // namespace sortie::testing
