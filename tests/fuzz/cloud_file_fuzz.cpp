// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: bytes that are said to be a kept cloud. The first one tells how: as they are, with
// the right checksum behind them, or as changes to the cloud of a room. What is taken must come out again to
// the bit (of version 1, as the cloud that is written then), be fit to grow planes from and to be looked
// along; what is refused leaves no cell, and a reason.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "mapping/registration/cloud_file.hpp"
#include "mapping/registration/sight_score.hpp"
#include "rt/digest.hpp"

using namespace sortie;
using namespace sortie::mapping;

namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t kCheckBytes = 8;
constexpr std::size_t kVersionByte = 8;
constexpr std::uint64_t kMostEntries = std::uint64_t{1} << 18;  // of a window that is tried: 1 MB
constexpr std::uint64_t kMostUnits = 10'000'000;

void require(bool condition) {
  if (!condition) std::abort();
}

/// A layer with memory of its own.
struct Cloud {
  explicit Cloud(const SightConfig& config) : memory(bytes_of(config)), arena(memory), layer(config, arena) {
    require(arena.refused() == 0);
  }
  static std::size_t bytes_of(const SightConfig& config) {
    rt::Arena measured({});
    const SightLayer none(config, measured);
    return static_cast<std::size_t>(measured.needed_bytes());
  }
  Bytes written(CloudSensor sensor) const {
    Bytes out(static_cast<std::size_t>(cloud_bytes(layer)));
    require(write_cloud(layer, sensor, out) == Status::ok);
    return out;
  }
  std::vector<std::byte> memory;
  rt::Arena arena;
  SightLayer layer;
};

class Rig {
 public:
  Rig() {
    // A room of 8 x 6 x 2.4 m, seen from its middle.
    std::vector<rt::Vector3> points;
    for (int row = -20; row <= 20; ++row) {
      for (int column = 0; column < 90; ++column) {
        const double up = 0.06 * row, round = 0.0698 * column;
        const rt::Vector3 ray{std::cos(up) * std::cos(round), std::cos(up) * std::sin(round), std::sin(up)};
        const double far = std::min({4.0 / std::abs(ray.x), 3.0 / std::abs(ray.y), 1.2 / std::abs(ray.z)});
        points.push_back(far * ray);
      }
    }
    require(room_.layer.insert(points, {}) == Status::ok);
    bytes_ = room_.written(CloudSensor::laser);
  }

  const Bytes& room() const { return bytes_; }

  void check(std::span<const std::uint8_t> bytes) {
    const CloudFileResult needs = read_cloud_head(bytes);
    const CloudFileResult result = load_cloud(bytes, room_.layer);
    require(room_.layer.cells().empty());
    if (result.fault != CloudFileFault::none) {
      require(room_.layer.size() == 0 && result.why[0] != '\0');
    } else {
      use(room_, needs.sensor, bytes);
    }
    if (needs.fault != CloudFileFault::none) {
      require(result.fault == needs.fault && result.byte <= bytes.size());
      return;
    }
    const SightConfig& config = needs.config;
    if (std::uint64_t{config.window_cells} * config.window_cells * config.window_cells_up > kMostEntries)
      return;
    Cloud asked(config);
    require(load_cloud(bytes, asked.layer).fault == CloudFileFault::none);
    use(asked, needs.sensor, bytes);
  }

 private:
  static void use(Cloud& cloud, CloudSensor sensor, std::span<const std::uint8_t> bytes) {
    SightLayer& layer = cloud.layer;
    const Bytes written = cloud.written(sensor);
    if (bytes[kVersionByte] == CloudFileHead::kVersion) {
      require(std::ranges::equal(written, bytes));
    } else {
      require(load_cloud(written, layer).fault == CloudFileFault::none);
      require(cloud.written(sensor) == written);
    }
    layer.prepare();
    for (const SightCell& cell : layer.cells()) {
      require(rt::is_finite(cell.mean_m) && rt::is_finite(cell.from_m) && std::isfinite(cell.sigma_m));
      require(std::abs(rt::norm(cell.normal) - 1.0) < 1e-3);
    }
    std::vector<std::uint64_t> bits[3];
    for (auto& words : bits) words.resize(layer.cells().size() / 64 + 1);
    const SightCount count = count_sights(layer.cells(), layer, {}, {}, {bits[0], bits[1], bits[2]});
    require(std::uint64_t{count.on} + count.off <= layer.cells().size());
    grow(layer, sensor);
  }

  static void grow(const SightLayer& layer, CloudSensor sensor) {
    const std::size_t room = std::max<std::size_t>(layer.size(), 1);
    std::vector<PlaneCellSlot> cells(room);
    std::vector<std::uint32_t> table(std::bit_ceil(2 * room)), queue(room);
    std::vector<std::uint64_t> heap(room);
    std::vector<PlaneRegion> regions(4 * kMostPlanes);
    PlaneGrowingConfig config = growing_config(sensor);
    config.cell_m = layer.cell_m();
    PlaneGrowing growing(config, {cells, table, heap, queue, regions});
    layer.for_each_plane_cell(layer.by_key(),
                              [&](const PlaneCell& cell) { require(growing.set_cell(cell) == Status::ok); });
    std::uint64_t units = kMostUnits;
    require(growing.run(units));
    PlaneSet planes;
    growing.planes(planes);
    for (const Plane& plane : planes)
      require(rt::is_finite(plane.centroid_m) && std::abs(rt::norm(plane.normal) - 1.0) < 1e-3);
  }

  static SightConfig room_config() {
    SightConfig config = sight_config(CloudSensor::laser);
    config.cell_m = 0.8;
    config.cells = 512;
    config.window_cells = 32;
    config.window_cells_up = 16;
    return config;
  }

  Cloud room_{room_config()};
  Bytes bytes_;
};

void seal(Bytes& cloud) {
  std::uint64_t check = rt::digest_bytes(cloud.data(), cloud.size());
  for (std::size_t i = 0; i < kCheckBytes; ++i, check >>= 8)
    cloud.push_back(static_cast<std::uint8_t>(check & 0xff));
}

/// Three bytes a change: where, and what is put there.
Bytes changed(const Bytes& room, std::span<const std::uint8_t> changes) {
  Bytes cloud(room.begin(), room.end() - kCheckBytes);
  for (; changes.size() >= 3; changes = changes.subspan(3))
    cloud[(std::size_t{changes[0]} | std::size_t{changes[1]} << 8) % cloud.size()] = changes[2];
  return cloud;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Rig rig;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest{data + 1, size - 1};
  Bytes cloud = data[0] % 3 == 2 ? changed(rig.room(), rest) : Bytes(rest.begin(), rest.end());
  if (data[0] % 3 != 0) seal(cloud);
  rig.check(cloud);
  return 0;
}
