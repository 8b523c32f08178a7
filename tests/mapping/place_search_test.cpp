// SPDX-License-Identifier: BSD-3-Clause
// The search of a place finds what looking at every pose finds, at any budget, and the true place among it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "mapping/registration/place_returns.hpp"
#include "rt/digest.hpp"
#include "rt/math.hpp"
#include "tests/mapping/place_rig.hpp"

namespace {
using namespace sortie;
using mapping::PlaceCandidate;
using mapping::PlaceSearch;

/// For each voxel, whether a surface comes within half a voxel of it, plus whether it goes through: from the
/// surfels, without the maps of bits.
struct PlainMap {
  std::int32_t first[3]{}, size[3]{};
  std::vector<int> worth;

  explicit PlainMap(const mapping::SurfelLayer& layer) {
    std::int32_t last[3]{};
    bool some = false;
    const auto each = [&](auto call) {
      for (std::size_t i = 0; i < layer.keys().size(); ++i) {
        if (layer.keys()[i] != mapping::SurfelLayer::kUnused)
          call(mapping::SurfelCell::from_key(layer.keys()[i]), layer.surfel(static_cast<std::uint32_t>(i)));
      }
    };
    each([&](const mapping::SurfelCell& cell, const mapping::Surfel&) {
      for (int i = 0; i < 3; ++i) {
        first[i] = some ? std::min(first[i], cell.at[i]) : cell.at[i];
        last[i] = some ? std::max(last[i], cell.at[i]) : cell.at[i];
      }
      some = true;
    });
    for (int i = 0; i < 3; ++i) size[i] = 2 * (last[i] - first[i] + 1) + 2;
    worth.resize(static_cast<std::size_t>(size[0] * size[1] * size[2]));
    const double half = 0.5 * layer.cell_m();
    for (int wide = 1; wide <= 2; ++wide) {
      std::vector<bool> there(worth.size());
      each([&](const mapping::SurfelCell& cell, const mapping::Surfel& surfel) {
        if (surfel.count > 0) draw(surfel, cell, half, wide, there);
      });
      for (std::size_t i = 0; i < there.size(); ++i) worth[i] += there[i];
    }
  }
  void draw(const mapping::Surfel& surfel, const mapping::SurfelCell& cell, double half, int wide,
            std::vector<bool>& there) const {
    for (int k = 0; k < 64; ++k) {
      const int at[3] = {k % 4 - 1, k / 4 % 4 - 1, k / 16 - 1};
      const rt::Vector3 off =
          rt::Vector3{(at[0] - 0.5) * half, (at[1] - 0.5) * half, (at[2] - 0.5) * half} - surfel.mean();
      bool inside = true;
      for (int i = 0; i < 3; ++i) {
        const rt::Vector3 a = surfel.along(i);
        const double reach = 2.0 * std::sqrt(surfel.variance(i)) +
                             0.5 * wide * half * (std::fabs(a.x) + std::fabs(a.y) + std::fabs(a.z));
        inside = inside && std::fabs(rt::dot(off, a)) <= reach;
      }
      if (inside)
        there[index(2 * (cell.at[0] - first[0]) + at[0] + 1, 2 * (cell.at[1] - first[1]) + at[1] + 1,
                    2 * (cell.at[2] - first[2]) + at[2] + 1)] = true;
    }
  }
  std::size_t index(int x, int y, int z) const {
    return static_cast<std::size_t>((z * size[1] + y) * size[0] + x);
  }
  int at(int x, int y, int z) const {  // voxels from -1
    ++x, ++y, ++z;
    const bool inside = x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2];
    return inside ? worth[index(x, y, z)] : 0;
  }
};

/// All poses, one by one, in the order of the search.
std::vector<PlaceCandidate> look_everywhere(const testing::PlaceRig& rig,
                                            const std::vector<rt::Vector3>& returns,
                                            const mapping::PlaceSearchConfig& config) {
  const PlainMap plain(rig.registration.layer(0));
  const double voxel = 0.5 * rig.registration.layer(0).cell_m();
  const PlaceSearch& search = rig.part.search();
  const auto least = [&](double best, double within) {
    return std::max(
        1u, static_cast<std::uint32_t>(std::max(config.least_hits * 2.0 * static_cast<double>(returns.size()),
                                                (1.0 - within) * best)));
  };
  std::vector<PlaceCandidate> all;
  std::uint32_t most = 0;
  for (std::int32_t turn = 0; turn < PlaceSearch::kTurns; ++turn) {
    const double c = rt::cos(PlaceSearch::turn_rad(turn)), s = rt::sin(PlaceSearch::turn_rad(turn));
    std::vector<int> offset;
    for (const rt::Vector3& v : returns) {
      for (const double along : {c * v.x - s * v.y, s * v.x + c * v.y, v.z})
        offset.push_back(static_cast<int>(rt::floor(along / voxel + 0.5)));
    }
    for (std::uint32_t node = 0; node < static_cast<std::uint32_t>(64 * rig.part.map().tops()); ++node) {
      for (int lane = 0; lane < 64; ++lane) {
        const mapping::PlaceCell cell = search.cell(turn, node, lane);
        std::uint32_t hits = 0;
        for (std::size_t i = 0; i < offset.size(); i += 3)
          hits += static_cast<std::uint32_t>(
              plain.at(cell.at[0] + offset[i], cell.at[1] + offset[i + 1], cell.at[2] + offset[i + 2]));
        if (hits < least(most, config.rivals_within)) continue;
        most = std::max(most, hits);
        all.push_back({cell, hits});
      }
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.hits > b.hits; });
  std::vector<PlaceCandidate> found;
  const auto pick = [&](std::size_t up_to, double within, auto wanted) {
    for (const PlaceCandidate& one : all) {
      if (found.size() == up_to || one.hits < least(most, within)) return;
      const auto near = [&](const auto& f) { return PlaceSearch::near(f.cell, one.cell); };
      if (wanted(one) && std::none_of(found.begin(), found.end(), near)) found.push_back(one);
    }
  };
  pick(config.candidates, config.within, [](const auto&) { return true; });
  pick(found.size() + config.rivals, config.rivals_within, [&](const PlaceCandidate& one) {
    return (one.cell.turn - found[0].cell.turn + 1 + 4 * PlaceSearch::kTurns) % (PlaceSearch::kTurns / 4) <=
           2;
  });
  return found;
}

testing::PlaceWorld small_hall(testing::Draws& draws) {
  testing::PlaceWorld world;
  world.wide = draws.uniform(4, 7);
  world.deep = draws.uniform(4, 7);
  world.storey = 2.5;
  testing::add_shell(world);
  testing::add_things(world, draws, {0, 0, 0}, {world.wide, world.deep, 2.5}, 4);
  world.index();
  return world;
}

constexpr mapping::RegistrationMemory kSmall{8192, 64, 32};

}  // namespace

TEST_CASE("The search of a place finds what looking at every pose finds", "[heavy]") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  mapping::PlaceSearchConfig config;
  config.returns = 61;  // no whole number of fours
  config.candidates = 12;
  testing::PlaceRig rig(kSmall, {}, config);
  for (int trial = 0; trial < 2; ++trial) {
    const testing::PlaceWorld world = small_hall(draws);
    rig.make_map(world, draws, 2.0);
    REQUIRE(rig.part.has_map());
    const testing::LostRobot robot(world, draws);
    const auto scan = testing::place_scan({16, 180}, world, robot.pose.p, robot.pose.q, draws);
    rig.find(scan, robot.q_level_sensor);
    rig.registration.take(scan);
    std::vector<rt::Vector3> returns(config.returns);
    returns.resize(mapping::choose_place_returns(rig.registration.sample(), robot.q_level_sensor,
                                                 config.reach_m, returns));
    const std::vector<PlaceCandidate> all = look_everywhere(rig, returns, config);
    const auto found = rig.part.search().found();
    REQUIRE(found.size() == all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      CAPTURE(trial, i);
      CHECK(found[i].hits == all[i].hits);
      CHECK(rt::digest_of(found[i].cell) == rt::digest_of(all[i].cell));
    }
  }
}

TEST_CASE("A search without a map or without returns is done at once and finds nothing") {
  testing::PlaceRig rig(kSmall);
  CHECK_FALSE(rig.part.take_map());
  std::vector<rt::ScanPoint> scan(2000);
  for (std::size_t i = 0; i < scan.size(); ++i)
    scan[i] = {3.0F, 0.01F * static_cast<float>(i % 200), 0.1F * static_cast<float>(i / 200), 0, 0};
  CHECK(rig.find({}, {}).verdict == mapping::RelocateVerdict::few_returns);
  CHECK(rig.find(scan, {}).verdict != mapping::RelocateVerdict::placed);
  for (rt::ScanPoint& p : scan) p.x_m = NAN;
  CHECK(rig.find(scan, {}).verdict == mapping::RelocateVerdict::few_returns);
}
