// SPDX-License-Identifier: BSD-3-Clause
// A kept cloud: the same bits as the one that was written.
#include <algorithm>
#include <random>
#include <string>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/cloud_file_rig.hpp"

using namespace sortie;
using namespace sortie::tests;
using mapping::CloudFileFault;
using mapping::CloudFileResult;
using mapping::CloudSensor;

TEST_CASE(
    "A kept cloud is the same to the bit in the layer that its head asks for, and again the same bytes") {
  const std::uint32_t seed = std::random_device{}();
  CAPTURE(seed);
  WorldRandom random(seed);
  const Building building = random_building(random);
  for (const CloudSensor sensor : {CloudSensor::laser, CloudSensor::camera}) {
    OwnedSight made(mapping::sight_config(sensor));
    made.fill(sensor == CloudSensor::laser ? ground_cloud(building, 0.2, 0.8, random)
                                           : air_cloud(building, 0.2, 0.8, random));
    const CloudBytes bytes = cloud_of(made.layer, sensor);
    const CloudFileResult needs = mapping::read_cloud_head(bytes);
    REQUIRE(needs.fault == CloudFileFault::none);
    CHECK(std::string(needs.why).empty());
    CHECK(needs.sensor == sensor);
    CHECK(needs.config.cells == made.layer.size());
    CHECK(needs.config.window_cells <= 128);
    OwnedSight loaded(needs.config);
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
  OwnedSight empty(small_layer());
  const CloudBytes nothing = cloud_of(empty.layer);
  CHECK(nothing.size() == kCloudHeadBytes + 8);
  OwnedSight loaded(mapping::read_cloud_head(nothing).config);
  CHECK(mapping::load_cloud(nothing, loaded.layer).fault == CloudFileFault::none);
  check_same_cloud(empty.layer, loaded.layer);
}

TEST_CASE("A layer that was loaded, or read back from its state, goes on as the one that was kept") {
  const std::uint32_t seed = std::random_device{}();
  CAPTURE(seed);
  WorldRandom random(seed);
  OwnedSight made(small_layer()), loaded(small_layer()), restored(small_layer());
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
    for (OwnedSight* one : {&made, &loaded, &restored})
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
  std::fill(nowhere.end() - 8, nowhere.end(), std::uint8_t{0xff});  // of the last cell's place
  rt::Archive other = rt::Archive::reading(nowhere);
  restored.layer.archive(other);
  CHECK(other.status() == Status::malformed);
  CHECK(restored.layer.size() == 0);
}

TEST_CASE("A cloud of the format's first version, with a Gaussian in each cell, is the same cloud") {
  OwnedSight made(small_layer()), loaded(small_layer());
  made.fill(small_cloud(9));
  const CloudBytes now = cloud_of(made.layer);
  CloudBytes first(now.begin(), now.begin() + kCloudHeadBytes);
  first[8] = 1;
  WorldRandom random(9);
  for (std::size_t cell = kCloudHeadBytes; cell + 8 < now.size(); cell += kCloudRecordBytes) {
    const auto at = now.begin() + static_cast<std::ptrdiff_t>(cell);
    first.insert(first.end(), at, at + kFromByte);
    for (int i = 0; i < 64; ++i) first.push_back(static_cast<std::uint8_t>(random.below(256)));
    first.insert(first.end(), at + kFromByte, at + kCloudRecordBytes);
  }
  first.resize(first.size() + 8);
  first = checked_anew(first);
  CHECK(mapping::read_cloud_head(first).config.cells == made.layer.size());
  REQUIRE(mapping::load_cloud(first, loaded.layer).fault == CloudFileFault::none);
  check_same_cloud(made.layer, loaded.layer);
}
