// SPDX-License-Identifier: BSD-3-Clause
// What another robot knows, carried into a frame that lies across its own: against points within voxels.
#include "planner/uav_path/carried_map.hpp"

#include <catch2/catch.hpp>

#include "tests/planner/path_rig.hpp"

namespace sortie::planner::test {
namespace {

FlightMapConfig unknown_cube() {
  FlightMapConfig config = cube(32, 28, 12, 0.3, 0.15);
  config.unknown_is_blocked = true;
  return config;
}

std::size_t known_index(const FlightMapConfig& c, const Voxel3& v) {
  return static_cast<std::size_t>((v.z * c.ny + v.y) * c.nx + v.x);
}

/// Walls of one voxel, and pieces of everything.
std::vector<CellState> random_states(const FlightMapConfig& c, std::mt19937& random) {
  std::vector<CellState> known(static_cast<std::size_t>(c.nx * c.ny * c.nz), CellState::free);
  for (CellState& state : known) {
    const auto drawn = random() % 40;
    if (drawn == 0) state = CellState::blocked;
    if (drawn < 3 && drawn > 0) state = CellState::unknown;
  }
  for (int wall = 0; wall < 3; ++wall) {
    const auto at = static_cast<std::int32_t>(random() % 28);
    const bool along_x = random() % 2 == 0;
    for (std::int32_t z = 0; z < c.nz; ++z) {
      for (std::int32_t k = 0; k < (along_x ? c.nx : c.ny); ++k)
        known[known_index(c, along_x ? Voxel3{k, at, z} : Voxel3{at, k, z})] = CellState::blocked;
    }
  }
  return known;
}

CellState state_of(const std::vector<CellState>& known, const FlightMap& map, const rt::Vector3& p_m) {
  const Voxel3 v = map.voxel_at(p_m);
  return map.is_inside(v) ? known[known_index(map.config(), v)] : CellState::unknown;
}

void carry_all(CarriedMap& carried) {
  while (carried.works()) carried.step();
}

struct Turned {
  rt::Vector3 p;
  rt::Quaternion q;
  rt::Vector3 at(const rt::Vector3& own) const { return rt::rotate(q, own) + p; }
};

Turned random_turn(std::mt19937& random) {
  const auto draw = [&random](double most) {
    return most * (2.0 * static_cast<double>(random()) / 4294967295.0 - 1.0);
  };
  const double x = draw(1.5), y = draw(1.5), z = draw(0.3), yaw = draw(3.1), pitch = draw(0.02);
  return {{x, y, z}, rt::from_yaw_pitch_roll(yaw, pitch, draw(0.02))};
}

}  // namespace

TEST_CASE("carried map: no point of a voxel that may be entered lies in what is blocked") {
  const std::uint32_t seed = 5;
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::uint32_t blocked = 0, free = 0, points = 0;
  for (int round = 0; round < 12; ++round) {
    OwnedMap own(unknown_cube());
    const FlightMapConfig& c = own.map.config();
    const std::vector<CellState> known = random_states(c, random);
    const Turned turned = random_turn(random);
    CarriedMap carried(known, own.map);
    REQUIRE_FALSE(carried.works());
    carried.begin(turned.p, turned.q);
    carry_all(carried);
    for (std::int32_t n = 0; n < c.nx * c.ny * c.nz; ++n) {
      const Voxel3 v{n % c.nx, n / c.nx % c.ny, n / (c.nx * c.ny)};
      const rt::Vector3 middle = own.map.middle_m(v);
      bool touched = false;
      for (int k = 0; k < 30; ++k) {
        const auto jitter = [&random, &c] {
          return c.voxel_m * (static_cast<double>(random()) / 4294967296.0 - 0.5);
        };
        const double x = jitter(), y = jitter();
        const rt::Vector3 p = turned.at(middle + rt::Vector3{x, y, jitter()});
        touched = touched || state_of(known, own.map, p) == CellState::blocked;
        ++points;
      }
      if (touched) REQUIRE(own.map.is_blocked(v));
      if (own.map.is_blocked(v)) {
        ++blocked;
        continue;
      }
      ++free;
      REQUIRE(state_of(known, own.map, turned.at(middle)) == CellState::free);
    }
  }
  CHECK(points > 3'000'000);
  CHECK(blocked > 10'000);
  CHECK(free > 10'000);
}

TEST_CASE("carried map: what is free with a voxel's diagonal to spare is free, and the unknown stays") {
  const std::uint32_t seed = 6;
  CAPTURE(seed);
  std::mt19937 random(seed);
  OwnedMap own(unknown_cube());
  const FlightMapConfig& c = own.map.config();
  std::vector<CellState> known(static_cast<std::size_t>(c.nx * c.ny * c.nz), CellState::unknown);
  for (std::int32_t n = 0; n < c.nx * c.ny * c.nz; ++n) {
    const Voxel3 v{n % c.nx, n / c.nx % c.ny, n / (c.nx * c.ny)};
    if (v.x >= 4 && v.x < 24) known[known_index(c, v)] = CellState::free;
    if (v.x == 24) known[known_index(c, v)] = CellState::blocked;
  }
  const Turned turned{{0.53, -0.31, 0.07}, rt::from_yaw_pitch_roll(0.15, 0.01, -0.01)};
  CarriedMap carried(known, own.map);
  carried.begin(turned.p, turned.q);
  carry_all(carried);
  std::uint32_t spared = 0, kept = 0;
  for (std::int32_t n = 0; n < c.nx * c.ny * c.nz; ++n) {
    const Voxel3 v{n % c.nx, n / c.nx % c.ny, n / (c.nx * c.ny)};
    const rt::Vector3 p = turned.at(own.map.middle_m(v));
    const double x = (p.x - c.origin_m.x) / c.voxel_m;
    const double y = (p.y - c.origin_m.y) / c.voxel_m, z = (p.z - c.origin_m.z) / c.voxel_m;
    const bool within = y > 1 && y < c.ny - 1 && z > 1 && z < c.nz - 1;
    if (within && x > 5.8 && x < 22.2) {
      ++spared;
      REQUIRE_FALSE(own.map.is_blocked(v));
    }
    if (x < 4 || x > 27) {
      ++kept;
      REQUIRE(own.map.is_blocked(v));  // as a map that knows nothing
    }
  }
  CHECK(spared > 1000);
  CHECK(kept > 500);
}

TEST_CASE("carried map: in one and the same frame it is the other's map, slice by slice and taken up again") {
  const std::uint32_t seed = 7;
  CAPTURE(seed);
  std::mt19937 random(seed);
  OwnedMap own(unknown_cube()), other(unknown_cube()), twin(unknown_cube());
  const FlightMapConfig& c = own.map.config();
  const std::vector<CellState> known = random_states(c, random);
  put_known(known, twin.map);
  CarriedMap carried(known, own.map);
  carried.begin({}, {});
  for (int k = 0; k < 100; ++k) carried.step();
  std::vector<std::uint8_t> bytes(1 << 20);
  rt::Archive out = rt::Archive::writing(bytes);
  carried.archive(out);
  own.map.archive(out);
  REQUIRE(out.status() == Status::ok);
  CarriedMap again(known, other.map);
  rt::Archive in = rt::Archive::reading({bytes.data(), static_cast<std::size_t>(out.bytes())});
  again.archive(in);
  other.map.archive(in);
  REQUIRE(in.status() == Status::ok);
  CHECK(again.works());
  carry_all(carried);
  carry_all(again);
  for (std::int32_t n = 0; n < c.nx * c.ny * c.nz; ++n) {
    const Voxel3 v{n % c.nx, n / c.nx % c.ny, n / (c.nx * c.ny)};
    REQUIRE(own.map.is_blocked(v) == twin.map.is_blocked(v));
    REQUIRE(other.map.is_blocked(v) == twin.map.is_blocked(v));
  }
}

}  // namespace sortie::planner::test
