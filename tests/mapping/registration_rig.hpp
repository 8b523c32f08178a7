// SPDX-License-Identifier: BSD-3-Clause
// Parts of registration with memory of their own, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "mapping/registration/locator.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::testing {

/// A layer of surfels with memory of its own.
struct OwnedSurfelLayer {
  std::vector<mapping::SurfelIndex> window;
  std::vector<std::uint64_t> keys;
  std::vector<mapping::SurfelSums> sums;
  std::vector<mapping::Surfel> surfels;
  std::vector<mapping::SurfelIndex> free;
  std::vector<std::uint32_t> newest;
  std::vector<mapping::SurfelIndex> others;
  std::vector<std::uint64_t> cells;
  mapping::SurfelLayer layer;

  OwnedSurfelLayer(double cell_m, unsigned bits_xy, unsigned bits_z, std::size_t most,
                   std::uint32_t min_points = 5, std::uint32_t memory_points = 8192)
      : window(std::size_t{1} << (2 * bits_xy + bits_z)),
        keys(most),
        sums(most),
        surfels(most),
        free(most),
        newest(most),
        others(most),
        layer(cell_m, bits_xy, bits_z, min_points, memory_points,
              {window, keys, sums, surfels, free, newest, others}) {}
  OwnedSurfelLayer(const OwnedSurfelLayer&) = delete;
  OwnedSurfelLayer& operator=(const OwnedSurfelLayer&) = delete;

  void insert(const std::vector<rt::Vector3>& points, std::uint32_t scan, const rt::Vector3& from = {}) {
    cells.resize(std::max(cells.size(), points.size()));
    layer.insert(points, from, scan, cells);
  }
};

/// Whether a ray comes from behind what the map has in a cell, as it is described: by the angle.
inline bool is_from_behind(const mapping::SurfelLayer& layer, const mapping::SurfelCell& cell,
                           const rt::Vector3& ray) {
  const mapping::Surfel* const surfel = layer.surfel_at(cell);
  if (surfel == nullptr || surfel->count < 16) return false;
  const double least = std::sqrt(surfel->variance(0)) / layer.cell_m();
  const double middle = std::sqrt(surfel->variance(1)) / layer.cell_m();
  if (least > 0.075 || middle < 2.0 * least || middle < 0.06) return false;
  return rt::dot(surfel->along(0), ray) / rt::norm(ray) >= 0.1;
}

/// A locator, or a registration, with memory of its own.
template <class Part>
struct OwnedPart {
  static constexpr std::size_t kBytes = std::size_t{32} << 20;
  std::unique_ptr<std::byte[]> bytes{new std::byte[kBytes]};
  rt::Arena arena{{bytes.get(), kBytes}};
  Part part;

  template <class... Arguments>
  explicit OwnedPart(const mapping::RegistrationConfig& config, Arguments... arguments)
      : part(config, arena, arguments...) {}
};
using OwnedLocator = OwnedPart<mapping::Locator>;
using OwnedRegistration = OwnedPart<mapping::ScanRegistration>;

/// A room with boxes and a column about its middle: near enough that every part of it is seen densely.
inline RegistrationWorld small_room(Draws& draws) {
  RegistrationWorld world;
  const rt::Vector3 half{draws.uniform(3.5, 5), draws.uniform(3, 4.5), 1.3};
  world.boxes.push_back({{0, 0, half.z}, half, 0});
  for (const double side : {-1.0, 1.0}) {
    const rt::Vector3 size{draws.uniform(0.3, 0.6), draws.uniform(0.3, 0.6), draws.uniform(0.4, 1)};
    world.boxes.push_back(
        {{side * draws.uniform(2, 3), draws.uniform(-2, 2), size.z}, size, draws.uniform(0, 3)});
  }
  world.columns.push_back({{draws.uniform(-1, 1), 2.2, 0}, {0, 0, 1}, 0.25});
  return world;
}

/// In another order, the same with every standard library.
template <class T>
void shuffle(std::vector<T>& list, Draws& draws) {
  for (std::size_t i = list.size(); i > 1; --i)
    std::swap(list[i - 1], list[static_cast<std::size_t>(draws.uniform(0, static_cast<double>(i)))]);
}

/// A scan's returns in the map's frame.
inline std::vector<rt::Vector3> placed(const std::vector<rt::ScanPoint>& scan,
                                       const mapping::RigidPose& pose) {
  std::vector<rt::Vector3> out;
  for (const rt::ScanPoint& p : scan)
    out.push_back(rt::rotate(pose.q, {static_cast<double>(p.x_m), static_cast<double>(p.y_m),
                                      static_cast<double>(p.z_m)}) +
                  pose.p);
  return out;
}

inline std::vector<mapping::SamplePoint> as_sample(const std::vector<rt::ScanPoint>& scan) {
  std::vector<mapping::SamplePoint> out;
  for (const rt::ScanPoint& p : scan) out.push_back({p.x_m, p.y_m, p.z_m});
  return out;
}

}  // namespace sortie::testing
