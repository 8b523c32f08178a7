// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: bytes that are said to be a kept map. The first one tells how: as they are, with the
// right checksum behind them, or as changes to the map of a room. What is taken must come out again to the
// bit and be fit to match and to search on; what is refused leaves no map, and a reason.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "mapping/registration/relocaliser.hpp"
#include "mapping/registration/surfel_map.hpp"
#include "rt/digest.hpp"

using namespace sortie;
using namespace sortie::mapping;

namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t kCheckBytes = 8;
constexpr std::uint64_t kMostUnits = 50'000'000;

void require(bool condition) {
  if (!condition) std::abort();
}

class Rig {
 public:
  Rig() {
    require(arena_.refused() == 0);
    for (int i = 0; i < 3; ++i) {
      points_.clear();
      for (int row = -6; row <= 6; ++row) {
        for (int column = 0; column < 90; ++column) see(0.07 * row, 0.0698 * column + 0.02 * i);
      }
      registration_.take(points_);
      registration_.insert({});
    }
    registration_.insert({{8.0, 0.0, 0.0}, {}});  // the room behind the wall: both sides of it are known
    room_ = written();
  }

  const Bytes& room() const { return room_; }

  void check(std::span<const std::uint8_t> map) {
    const SurfelMapResult result = load_surfel_map(map, registration_);
    if (result.fault != SurfelMapFault::none) {
      for (int level = 0; level < kSurfelLayers; ++level) require(registration_.layer(level).size() == 0);
      require(result.fault != SurfelMapFault::surfel || result.why[0] != '\0');
    } else {
      require(std::ranges::equal(written(), map));
      for (int level = 0; level < kSurfelLayers; ++level) check_surfels(registration_.layer(level));
    }
    registration_.take(points_);
    const Match match = registration_.match({}, {}, {}, 0.0);
    require(rt::is_finite(match.pose.p) && std::abs(rt::squared_norm(match.pose.q) - 1.0) < 1e-6);
    if (!relocaliser_.take_map()) return;
    relocaliser_.begin(registration_.sample(), {});
    std::uint64_t units = kMostUnits;
    require(relocaliser_.run(units));
    require(relocaliser_.result().verdict != RelocateVerdict::searching);
  }

 private:
  /// Each is found by its cell, and lies in it.
  static void check_surfels(const SurfelLayer& layer) {
    for (const SurfelIndex index : layer.by_key()) {
      const SurfelRecord one = layer.record(index);
      const SurfelIndex first = layer.find(SurfelCell::from_key(one.key));
      require(first != kNoSurfel);
      require(((one.key & SurfelRecord::kOtherSide) != 0 ? layer.other_side(first) : first) == index);
      for (int i = 0; i < 3 && one.surfel.count > 0; ++i) {
        require(rt::norm(one.surfel.along(i)) < 1.1);
        require(std::abs(static_cast<double>(one.surfel.mean_m[i])) < 0.51 * layer.cell_m());
        require(one.surfel.variance(i) >= 0.0 &&
                one.surfel.variance(i) < 2.0 * layer.cell_m() * layer.cell_m());
      }
    }
  }
  /// A return of a room of 8 x 6 x 2.4 m, seen from its middle.
  void see(double up, double round) {
    const rt::Vector3 ray{std::cos(up) * std::cos(round), std::cos(up) * std::sin(round), std::sin(up)};
    const double far = std::min({4.0 / std::abs(ray.x), 3.0 / std::abs(ray.y), 1.2 / std::abs(ray.z)});
    rt::ScanPoint point;
    point.x_m = static_cast<float>(far * ray.x);
    point.y_m = static_cast<float>(far * ray.y);
    point.z_m = static_cast<float>(far * ray.z);
    points_.push_back(point);
  }
  Bytes written() const {
    Bytes map(static_cast<std::size_t>(surfel_map_bytes(registration_)));
    require(write_surfel_map(registration_, map) == Status::ok);
    return map;
  }

  static constexpr RegistrationMemory kMemory{2048, 64, 32};
  static constexpr std::size_t kArena = std::size_t{16} << 20;
  std::unique_ptr<std::byte[]> memory_{new std::byte[kArena]};
  rt::Arena arena_{{memory_.get(), kArena}};
  ScanRegistration registration_{{}, arena_, kMemory};
  Relocaliser relocaliser_{{}, {.tops = 64}, kMemory, registration_, arena_};
  std::vector<rt::ScanPoint> points_;
  Bytes room_;
};

void seal(Bytes& map) {
  std::uint64_t check = rt::digest_bytes(map.data(), map.size());
  for (std::size_t i = 0; i < kCheckBytes; ++i, check >>= 8)
    map.push_back(static_cast<std::uint8_t>(check & 0xff));
}

/// Three bytes a change: where, and what is put there.
Bytes changed(const Bytes& room, std::span<const std::uint8_t> changes) {
  Bytes map(room.begin(), room.end() - kCheckBytes);
  for (; changes.size() >= 3; changes = changes.subspan(3))
    map[(std::size_t{changes[0]} | std::size_t{changes[1]} << 8) % map.size()] = changes[2];
  return map;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Rig rig;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest{data + 1, size - 1};
  Bytes map = data[0] % 3 == 2 ? changed(rig.room(), rest) : Bytes(rest.begin(), rest.end());
  if (data[0] % 3 != 0) seal(map);
  rig.check(map);
  return 0;
}
