// SPDX-License-Identifier: BSD-3-Clause
// A kept cloud: the same bits as the one that was written, and nothing in its bytes is trusted.
#include "mapping/registration/cloud_file.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <string>

#include "rt/digest.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/cloud_trials.hpp"

namespace {
using namespace sortie;
using mapping::CloudFileFault;
using mapping::CloudFileResult;
using mapping::CloudSensor;
using CloudBytes = std::vector<std::uint8_t>;

constexpr std::size_t kCloudHeadBytes = 56;
constexpr std::size_t kCloudRecordBytes = 164;
constexpr std::size_t kFromByte = 136;  // of a record

CloudBytes cloud_of(const mapping::SightLayer& layer, CloudSensor sensor = CloudSensor::laser) {
  CloudBytes bytes(static_cast<std::size_t>(mapping::cloud_bytes(layer)));
  REQUIRE(mapping::write_cloud(layer, sensor, bytes) == Status::ok);
  return bytes;
}

/// With a check sum that fits, whatever was changed.
CloudBytes checked_anew(CloudBytes bytes) {
  const std::uint64_t check = rt::digest_bytes(bytes.data(), bytes.size() - 8);
  for (std::size_t i = 0; i < 8; ++i)
    bytes[bytes.size() - 8 + i] = static_cast<std::uint8_t>(check >> (8 * i));
  return bytes;
}

template <class T>
CloudBytes with(CloudBytes bytes, std::size_t at, T value) {
  rt::Archive archive = rt::Archive::writing(std::span(bytes).subspan(at));
  archive.value(value);
  REQUIRE(archive.status() == Status::ok);
  return checked_anew(bytes);
}

/// Same cells, to the bit, found at the same places.
void check_same_cloud(mapping::SightLayer& a, mapping::SightLayer& b) {
  REQUIRE((cloud_of(a) == cloud_of(b)));
  a.prepare(), b.prepare();
  REQUIRE(a.cells().size() == b.cells().size());
  for (std::size_t i = 0; i < a.cells().size(); ++i) {
    const mapping::SightCell& p = a.cells()[i];
    const mapping::SightCell& q = b.cells()[i];
    REQUIRE(rt::digest_of(p.mean_m) == rt::digest_of(q.mean_m));
    REQUIRE(rt::digest_of(p.normal) == rt::digest_of(q.normal));
    REQUIRE(rt::digest_of(p.from_m) == rt::digest_of(q.from_m));
    REQUIRE(p.sigma_m == q.sigma_m);
    REQUIRE(a.at(p.mean_m) == &p);
    REQUIRE(b.at(p.mean_m) == &q);
  }
  std::vector<std::uint64_t> first, second;
  a.for_each_plane_cell([&](const mapping::PlaneCell& cell) { first.push_back(rt::digest_of(cell)); });
  b.for_each_plane_cell([&](const mapping::PlaneCell& cell) { second.push_back(rt::digest_of(cell)); });
  REQUIRE(first.size() == a.size());
  REQUIRE(first == second);
}

/// Finite, in their cells, and such as planes are grown from.
void check_sound(mapping::SightLayer& layer) {
  layer.prepare();
  for (const mapping::SightCell& cell : layer.cells()) {
    REQUIRE((rt::is_finite(cell.mean_m) && rt::is_finite(cell.from_m) && std::isfinite(cell.sigma_m)));
    REQUIRE(std::fabs(rt::norm(cell.normal) - 1.0) < 1e-3);
  }
  tests::OwnedGrowing owned(mapping::growing_config(CloudSensor::laser), 256, 16);
  layer.for_each_plane_cell([&](const mapping::PlaneCell& cell) {
    REQUIRE(owned.growing.set_cell(cell) == Status::ok);
    for (const float part : cell.mean_m)
      REQUIRE(std::fabs(static_cast<double>(part)) <= 0.5001 * layer.cell_m());
  });
}

/// A corner of a room: three walls.
std::vector<tests::SeenPoint> small_cloud(std::uint32_t seed) {
  tests::WorldRandom random(seed);
  std::vector<tests::SeenPoint> out;
  for (int wall = 0; wall < 3; ++wall) {
    for (int i = 0; i < 200; ++i) {
      const double a = random.between(-0.3, 0.7), b = random.between(-0.3, 0.7), c = 0.005 * random.normal();
      const rt::Vector3 at = wall == 0   ? rt::Vector3{a, b, 0.9 + c}
                             : wall == 1 ? rt::Vector3{a, 0.9 + c, b}
                                         : rt::Vector3{0.9 + c, a, b};
      out.push_back({at, {0.1, 0.2, 0.3}});
    }
  }
  return out;
}

mapping::SightConfig small_layer() {
  mapping::SightConfig config;
  config.cells = 64;
  config.window_cells = 16;
  config.window_cells_up = 8;
  return config;
}
}  // namespace

TEST_CASE(
    "A kept cloud is the same to the bit in the layer that its head asks for, and again the same bytes") {
  const std::uint32_t seed = std::random_device{}();
  CAPTURE(seed);
  tests::WorldRandom random(seed);
  const tests::Building building = tests::random_building(random);
  for (const CloudSensor sensor : {CloudSensor::laser, CloudSensor::camera}) {
    tests::OwnedSight made(mapping::sight_config(sensor));
    made.fill(sensor == CloudSensor::laser ? tests::ground_cloud(building, 0.2, 0.8, random)
                                           : tests::air_cloud(building, 0.2, 0.8, random));
    const CloudBytes bytes = cloud_of(made.layer, sensor);
    const CloudFileResult needs = mapping::read_cloud_head(bytes);
    REQUIRE(needs.fault == CloudFileFault::none);
    CHECK(std::string(needs.why).empty());
    CHECK(needs.sensor == sensor);
    CHECK(needs.config.cells == made.layer.size());
    CHECK(needs.config.window_cells <= 128);
    tests::OwnedSight loaded(needs.config);
    REQUIRE(loaded.arena.refused() == 0);
    CloudBytes again(bytes.size());
    CloudFileFault fault{};
    Status written{};
    std::uint64_t calls = 0;
    {
      const rt::posix::HeapTrapScope scope;
      fault = mapping::load_cloud(bytes, loaded.layer).fault;
      written = mapping::write_cloud(loaded.layer, sensor, again);
      calls = scope.calls();
    }
    CHECK(calls == 0);
    CHECK(fault == CloudFileFault::none);
    CHECK(written == Status::ok);
    CHECK(loaded.layer.cells().empty());
    CHECK((again == bytes));
    check_same_cloud(made.layer, loaded.layer);
    CHECK(loaded.layer.cells().size() > 100);
  }
  // A cloud of nothing is one, too.
  tests::OwnedSight empty(small_layer());
  const CloudBytes nothing = cloud_of(empty.layer);
  CHECK(nothing.size() == kCloudHeadBytes + 8);
  tests::OwnedSight loaded(mapping::read_cloud_head(nothing).config);
  CHECK(mapping::load_cloud(nothing, loaded.layer).fault == CloudFileFault::none);
  check_same_cloud(empty.layer, loaded.layer);
}

TEST_CASE("A layer that was loaded, or read back from its state, goes on as the one that was kept") {
  const std::uint32_t seed = std::random_device{}();
  CAPTURE(seed);
  tests::WorldRandom random(seed);
  tests::OwnedSight made(small_layer()), loaded(small_layer()), restored(small_layer());
  made.fill(small_cloud(seed));
  loaded.fill(small_cloud(seed + 1)), restored.fill(small_cloud(seed + 2));
  REQUIRE(mapping::load_cloud(cloud_of(made.layer), loaded.layer).fault == CloudFileFault::none);
  rt::Archive measure = rt::Archive::measuring();
  made.layer.archive(measure);
  CAPTURE(measure.where(), measure.why());
  REQUIRE(measure.status() == Status::ok);
  CloudBytes state(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(state);
  made.layer.archive(write);
  rt::Archive read = rt::Archive::reading(state);
  restored.layer.archive(read);
  REQUIRE(read.status() == Status::ok);
  CHECK(restored.layer.cells().empty());
  check_same_cloud(made.layer, loaded.layer);
  check_same_cloud(made.layer, restored.layer);
  for (int view = 0; view < 12; ++view) {
    // Half into one cell, which fades, the others as far as where cells of the window give way.
    std::vector<rt::Vector3> points;
    for (int i = 0; i < 4000; ++i) {
      const double far = i % 2 == 0 ? 0.2 : 3.0 + view;
      points.push_back({0.2 + 0.2 * random.between(-1, 1), random.between(-far, far), 0.05 + 0.01 * view});
    }
    const rt::Vector3 from{0.1 * view, 0, 2};
    for (tests::OwnedSight* one : {&made, &loaded, &restored})
      REQUIRE(one->layer.insert(points, from) == Status::ok);
    check_same_cloud(made.layer, loaded.layer);
    check_same_cloud(made.layer, restored.layer);
  }
  CHECK(made.layer.counts().evicted > 0);
  // Whatever the state's bytes say, there is a sound layer, or none.
  std::uint32_t refused = 0;
  for (std::size_t at = 0; at < state.size(); ++at) {
    CAPTURE(at);
    CloudBytes changed = state;
    changed[at] ^= static_cast<std::uint8_t>(1 + random.below(255));
    rt::Archive other = rt::Archive::reading(changed);
    restored.layer.archive(other);
    REQUIRE(restored.layer.cells().empty());
    if (other.status() != Status::ok) {
      REQUIRE(restored.layer.size() == 0);
      ++refused;
    }
    check_sound(restored.layer);
  }
  CHECK(refused > 100);
  CloudBytes nowhere = state;
  std::fill(nowhere.end() - 16, nowhere.end() - 8, std::uint8_t{0xff});  // of the last cell's place
  rt::Archive other = rt::Archive::reading(nowhere);
  restored.layer.archive(other);
  CHECK(other.status() == Status::malformed);
  CHECK(restored.layer.size() == 0);
}

TEST_CASE("A cloud that is cut off or damaged anywhere is refused by name, and leaves no cell") {
  const std::uint32_t seed = std::random_device{}();
  CAPTURE(seed);
  tests::WorldRandom random(seed);
  tests::OwnedSight owned(small_layer());
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
      if (at >= 52 && at < 56)  // the number of cells
        REQUIRE((fault == CloudFileFault::cells || fault == CloudFileFault::length));
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
  tests::WorldRandom random(seed);
  tests::OwnedSight owned(small_layer());
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
    tests::OwnedSight asked(needs.config);
    REQUIRE(asked.arena.refused() == 0);
    REQUIRE(mapping::load_cloud(changed, asked.layer).fault == CloudFileFault::none);
    REQUIRE((cloud_of(asked.layer, needs.sensor) == changed));
  }
  CAPTURE(taken, refused);
  CHECK((taken > 100 && refused > 100));
}

TEST_CASE("What a cloud must not say, and what a layer must not be for it, have their names and places") {
  tests::OwnedSight owned(small_layer());
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
  for (const std::uint32_t views : {0u, 1001u})
    CHECK(fault(with(good, 32, views)) == CloudFileFault::settings);
  for (const double most_m : {kNan, 0.0, 101.0})
    CHECK(fault(with(good, 36, most_m)) == CloudFileFault::settings);
  for (const double most : {kNan, 0.0, 1.01}) CHECK(fault(with(good, 44, most)) == CloudFileFault::settings);
  CHECK(fault(with(good, 52, mapping::kMostCloudCells + 1)) == CloudFileFault::cells);
  const std::size_t second = kCloudHeadBytes + kCloudRecordBytes;
  const CloudFileResult nowhere = mapping::read_cloud_head(with(good, second + kFromByte, kNan));
  CHECK(nowhere.fault == CloudFileFault::record);
  CHECK(nowhere.byte == second);
  CHECK(std::string(nowhere.why) == "a cell that was seen from nowhere");
  CHECK(std::string(mapping::read_cloud_head(with(good, second + kCloudRecordBytes - 4, 0u)).why) ==
        "a cell that nobody saw");
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
    tests::OwnedSight other(config);
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
  tests::OwnedSight made(small_layer()), owned(config);
  made.fill(small_cloud(8));
  const auto cells = made.layer.by_key();
  mapping::SightRecord one = made.layer.record(cells[0]);
  one.from_m.y = std::numeric_limits<double>::infinity();
  CHECK(owned.layer.put(one) == Status::malformed);
  one = made.layer.record(cells[0]);
  one.surfel.sums.count = 0;
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
