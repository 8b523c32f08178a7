// SPDX-License-Identifier: BSD-3-Clause
// Nothing in the bytes of a kept cloud is trusted.
#include <algorithm>
#include <limits>
#include <random>
#include <string>

#include "tests/mapping/cloud_file_rig.hpp"

using namespace sortie;
using namespace sortie::tests;
using mapping::CloudFileFault;
using mapping::CloudFileResult;
using mapping::CloudSensor;

TEST_CASE("A cloud that is cut off or damaged anywhere is refused by name, and leaves no cell") {
  const std::uint32_t seed = std::random_device{}();
  CAPTURE(seed);
  WorldRandom random(seed);
  OwnedSight owned(small_layer());
  owned.fill(small_cloud(seed));
  const CloudBytes good = cloud_of(owned.layer);
  REQUIRE(owned.layer.size() >= 12);
  const auto refused = [&](std::span<const std::uint8_t> bytes) {
    REQUIRE(mapping::load_cloud(good, owned.layer).fault == CloudFileFault::none);
    const CloudFileResult result = mapping::load_cloud(bytes, owned.layer);
    REQUIRE(owned.layer.size() == 0);
    REQUIRE(owned.layer.cells().empty());
    REQUIRE(!std::string(result.why).empty());
    REQUIRE(mapping::read_cloud_head(bytes).fault == result.fault);
    return result.fault;
  };
  for (std::size_t size = 0; size < good.size(); ++size) {
    CAPTURE(size);
    REQUIRE(refused(std::span(good).first(size)) ==
            (size < 8 ? CloudFileFault::no_cloud : CloudFileFault::length));
  }
  CloudBytes longer = good;
  longer.push_back(0);
  CHECK(refused(longer) == CloudFileFault::length);
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const std::uint32_t flip : {1u, 0x80u, 1 + random.below(255)}) {
      CAPTURE(at, flip);
      CloudBytes damaged = good;
      damaged[at] ^= static_cast<std::uint8_t>(flip);
      const CloudFileFault fault = refused(damaged);
      if (at >= 48 && at < 52)  // the number of cells
        REQUIRE((fault == CloudFileFault::cells || fault == CloudFileFault::length));
      else if (at == 8 && damaged[at] == 1)  // a version whose cells are longer
        REQUIRE(fault == CloudFileFault::length);
      else
        REQUIRE(fault == (at < 8    ? CloudFileFault::no_cloud
                          : at < 16 ? CloudFileFault::version
                                    : CloudFileFault::checksum));
    }
  }
}

TEST_CASE("Whatever is changed behind a right checksum is refused by name or makes a sound cloud") {
  const std::uint32_t seed = std::random_device{}();
  CAPTURE(seed);
  WorldRandom random(seed);
  OwnedSight owned(small_layer());
  owned.fill(small_cloud(seed));
  const CloudBytes good = cloud_of(owned.layer);
  std::uint32_t taken = 0, refused = 0;
  for (std::size_t at = 0; at + 8 < good.size(); ++at) {
    CAPTURE(at);
    CloudBytes changed = good;
    changed[at] ^= static_cast<std::uint8_t>(1 + random.below(255));
    changed = checked_anew(changed);
    const CloudFileResult needs = mapping::read_cloud_head(changed);
    REQUIRE(needs.fault != CloudFileFault::checksum);
    const CloudFileResult result = mapping::load_cloud(changed, owned.layer);
    REQUIRE((needs.fault == CloudFileFault::none || result.fault == needs.fault));
    if (result.fault != CloudFileFault::none) {
      REQUIRE(owned.layer.size() == 0);
      REQUIRE(!std::string(result.why).empty());
      ++refused;
    } else {
      REQUIRE((cloud_of(owned.layer, needs.sensor) == changed));
      check_sound(owned.layer);
      ++taken;
    }
    if (needs.fault != CloudFileFault::none) continue;
    OwnedSight asked(needs.config);
    REQUIRE(asked.arena.refused() == 0);
    REQUIRE(mapping::load_cloud(changed, asked.layer).fault == CloudFileFault::none);
    REQUIRE((cloud_of(asked.layer, needs.sensor) == changed));
  }
  CAPTURE(taken, refused);
  CHECK((taken > 100 && refused > 100));
}

TEST_CASE("What a cloud must not say, and what a layer must not be for it, have their names and places") {
  OwnedSight owned(small_layer());
  owned.fill(small_cloud(7));
  const CloudBytes good = cloud_of(owned.layer);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto fault = [](const CloudBytes& bytes) { return mapping::read_cloud_head(bytes).fault; };
  CHECK(fault(with(good, 12, std::uint32_t{1024})) == CloudFileFault::version);  // steps
  CHECK(fault(with(good, 16, std::uint32_t{2})) == CloudFileFault::sensor);
  CHECK(fault(with(good, 16, std::uint32_t{256})) == CloudFileFault::sensor);
  for (const double cell_m : {kNan, 0.0, -0.4, 0.009, 101.0})
    CHECK(fault(with(good, 20, cell_m)) == CloudFileFault::settings);
  for (const std::uint32_t points : {0u, mapping::kMostSurfelPoints + 1})
    CHECK(fault(with(good, 28, points)) == CloudFileFault::settings);
  for (const double most_m : {kNan, 0.0, 101.0})
    CHECK(fault(with(good, 32, most_m)) == CloudFileFault::settings);
  for (const double most : {kNan, 0.0, 1.01}) CHECK(fault(with(good, 40, most)) == CloudFileFault::settings);
  CHECK(fault(with(good, 48, mapping::kMostCloudCells + 1)) == CloudFileFault::cells);
  const std::size_t second = kCloudHeadBytes + kCloudRecordBytes;
  const CloudFileResult nowhere = mapping::read_cloud_head(with(good, second + kFromByte, kNan));
  CHECK(nowhere.fault == CloudFileFault::record);
  CHECK(nowhere.byte == second);
  CHECK(std::string(nowhere.why) == "a cell that was seen from nowhere");
  CloudBytes twice = good;
  std::copy_n(good.begin() + kCloudHeadBytes, kCloudRecordBytes,
              twice.begin() + static_cast<std::ptrdiff_t>(second));
  const CloudFileResult order = mapping::read_cloud_head(checked_anew(twice));
  CHECK(order.fault == CloudFileFault::order);
  CHECK(order.byte == second);
  // The last cell, as far away as cells go: wider than any window. Nobody writes such a cloud, either.
  const mapping::SurfelCell far{
      {mapping::SurfelCell::kLimit - 1, mapping::SurfelCell::kLimit - 1, mapping::SurfelCell::kLimit - 1}};
  CHECK(fault(with(good, good.size() - 8 - kCloudRecordBytes, far.key())) == CloudFileFault::window);
  const rt::Vector3 ends[2] = {{-3000, -3000, 0}, {3000, 3000, 0}};
  owned.layer.clear();
  REQUIRE(owned.layer.insert(ends, {}) == Status::ok);
  REQUIRE(owned.layer.size() == 2);
  CloudBytes out(std::max<std::size_t>(good.size(), 1024));
  CHECK(mapping::write_cloud(owned.layer, CloudSensor::laser, out) == Status::out_of_range);
  REQUIRE(mapping::load_cloud(good, owned.layer).fault == CloudFileFault::none);
  CHECK(mapping::write_cloud(owned.layer, static_cast<CloudSensor>(2), out) == Status::out_of_range);
  CHECK(mapping::write_cloud(owned.layer, CloudSensor::laser, std::span(out).first(good.size() - 1)) ==
        Status::full);

  const auto into = [&](auto change) {
    mapping::SightConfig config = small_layer();
    change(config);
    OwnedSight other(config);
    const CloudFileResult result = mapping::load_cloud(good, other.layer);
    CHECK((result.fault == CloudFileFault::none) == (other.layer.size() > 0));
    CHECK(result.config.cells == (good.size() - kCloudHeadBytes - 8) / kCloudRecordBytes);
    CHECK(result.config.window_cells == 4);
    return result.fault;
  };
  CHECK(into([](auto&) {}) == CloudFileFault::none);
  CHECK(into([](auto& c) { c.cell_m = 0.41; }) == CloudFileFault::cell);
  CHECK(into([](auto& c) { c.min_points = 9; }) == CloudFileFault::min_points);
  CHECK(into([](auto& c) { c.most_thickness_m = 0.06; }) == CloudFileFault::flat);
  CHECK(into([](auto& c) { c.most_flatness = 0.2; }) == CloudFileFault::flat);
  CHECK(into([](auto& c) { c.cells = 11; }) == CloudFileFault::room);
  CHECK(into([](auto& c) { c.window_cells = c.window_cells_up = 2; }) == CloudFileFault::window);
}

TEST_CASE("A layer does not take a cell that cannot be, that has no room, or whose place is taken") {
  mapping::SightConfig config = small_layer();
  config.cells = 2;
  OwnedSight made(small_layer()), owned(config);
  made.fill(small_cloud(8));
  const auto cells = made.layer.by_key();
  mapping::SightRecord one = made.layer.record(cells[0]);
  one.from_m.y = std::numeric_limits<double>::infinity();
  CHECK(owned.layer.put(one) == Status::malformed);
  one = made.layer.record(cells[0]);
  one.sums.count = 0;
  CHECK(owned.layer.put(one) == Status::malformed);
  one = made.layer.record(cells[0]);
  CHECK(owned.layer.put(one) == Status::ok);
  CHECK(owned.layer.put(one) == Status::out_of_range);
  owned.layer.prepare();
  CHECK(owned.layer.put(made.layer.record(cells[1])) == Status::ok);
  CHECK(owned.layer.cells().empty());
  CHECK(owned.layer.put(made.layer.record(cells[2])) == Status::full);
  CHECK(owned.layer.size() == 2);
}
