// SPDX-License-Identifier: BSD-3-Clause
// Height images that are kept, in a store and in files, and bytes that are neither.
#include "mapping/recognition/image_store.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <string>

#include "mapping/recognition/image_file.hpp"
#include "rt/digest.hpp"
#include "tests/mapping/image_rig.hpp"

namespace {
using namespace sortie;
using mapping::HeightImage;
using mapping::ImageFileFault;
using mapping::ImageRecord;
using testing::DrawnPose;
using testing::Draws;
using testing::OwnedImages;
using Bytes = std::vector<std::uint8_t>;

mapping::ImageStoreConfig small(std::uint32_t images) {
  mapping::ImageStoreConfig config;
  config.images = images;
  return config;
}

/// With so many cells of structure.
HeightImage image_with(int cells) {
  HeightImage image;
  for (int i = 0; i < cells; ++i) image.low.set(i % 128, i / 128);
  return image;
}

void put_at(OwnedImages& owned, double x, double y, int cells) {
  REQUIRE(owned.store.put(image_with(cells), testing::key_frame_of({x, y, 0}), 5, 1) == Status::ok);
}

void put_way(OwnedImages& owned, int images, Draws& draws) {
  const testing::DrawnPlace place = testing::draw_place(draws, 5);
  for (int i = 0; i < images; ++i) {
    const DrawnPose pose{draws.uniform(-30, 30), draws.uniform(-30, 30), draws.uniform(-3, 3)};
    (void)owned.store.put(testing::image_of(place, {0.1 * pose.x, 0.1 * pose.y, pose.yaw}, 12, draws),
                          testing::key_frame_of(pose), static_cast<std::uint32_t>(i), 3);
  }
}

Bytes written(const mapping::ImageStore& store) {
  Bytes bytes(static_cast<std::size_t>(mapping::image_file_bytes(store)));
  REQUIRE(mapping::write_images(store, std::span(bytes).first(bytes.size() - 1)) == Status::full);
  REQUIRE(mapping::write_images(store, bytes) == Status::ok);
  return bytes;
}

/// With the right checksum again.
Bytes sealed_images(Bytes bytes) {
  const std::uint64_t check = rt::digest_bytes(bytes.data(), bytes.size() - 8);
  std::memcpy(&bytes[bytes.size() - 8], &check, 8);
  return bytes;
}

bool same(const ImageRecord& a, const ImageRecord& b) {
  return a.image == b.image && a.pose == b.pose && a.cells == b.cells && a.stamp_ms == b.stamp_ms &&
         a.robot == b.robot;
}
bool same(const mapping::ImageStore& a, const mapping::ImageStore& b) {
  return std::equal(a.images().begin(), a.images().end(), b.images().begin(), b.images().end(),
                    [](const ImageRecord& x, const ImageRecord& y) { return same(x, y); });
}

}  // namespace

TEST_CASE("An image near a kept one takes its place where it shows more, else it is left out") {
  OwnedImages owned(small(8));
  put_at(owned, 0, 0, 80);
  put_at(owned, 2.9, 0, 90);  // not an eighth more
  REQUIRE(owned.store.images().size() == 1);
  CHECK(owned.store.images()[0].cells == 80);
  put_at(owned, 0, 2.9, 91);
  REQUIRE(owned.store.images().size() == 1);
  CHECK(owned.store.images()[0].cells == 91);
  CHECK(owned.store.images()[0].pose.place.y == 290);
  put_at(owned, 0, 0 - 0.1, 50);  // 3 m from where it is now
  CHECK(owned.store.images().size() == 2);
  mapping::KeyFramePose above = testing::key_frame_of({0, 0, 0});
  above.place.z = 300;  // another storey
  REQUIRE(owned.store.put(image_with(10), above, 0, 0) == Status::ok);
  CHECK(owned.store.images().size() == 3);
  CHECK(owned.store.counts().known == 1);
  CHECK(owned.store.counts().renewed == 1);
  CHECK(owned.store.counts().added == 3);
  above.heading = {};
  above.heading.cosine = 0;
  CHECK(owned.store.put(image_with(10), above, 0, 0) == Status::out_of_range);
  CHECK(owned.store.set_pose(3, {}) == Status::out_of_range);
  CHECK(owned.store.set_pose(2, above) == Status::out_of_range);
  above.heading = {};
  above.place.x = 77;
  CHECK(owned.store.set_pose(2, above) == Status::ok);
  CHECK(owned.store.images()[2].pose.place.x == 77);
  CHECK(owned.store.counts().refused == 1);
}

TEST_CASE("A full store gives up the image that is nearest to another one") {
  OwnedImages owned(small(3));
  put_at(owned, 0, 0, 80);
  put_at(owned, 10, 0, 70);
  put_at(owned, 14, 0, 90);
  put_at(owned, 40, 0, 10);  // 10 and 14 are the nearest two; the first of them shows less
  REQUIRE(owned.store.images().size() == 3);
  CHECK(owned.store.counts().evicted == 1);
  CHECK(owned.store.images()[0].pose.place.x == 0);
  CHECK(owned.store.images()[1].pose.place.x == 4000);
  CHECK(owned.store.images()[2].pose.place.x == 1400);
}

TEST_CASE("A store without memory keeps nothing") {
  std::byte little[64];
  rt::Arena arena({little, 64});
  mapping::ImageStore store({}, arena);
  CHECK(arena.refused() == 1);
  CHECK(store.put(image_with(3), {}, 0, 0) == Status::full);
  CHECK(store.images().empty());
}

TEST_CASE("Images come back from their file, and a store from its archive, as they were") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  for (int round = 0; round < 10; ++round) {
    OwnedImages one(small(12)), other(small(12)), third(small(12));
    put_way(one, static_cast<int>(draws.uniform(0, 40)), draws);
    put_way(other, 5, draws);
    put_way(third, 5, draws);
    const Bytes bytes = written(one.store);
    REQUIRE(mapping::load_images(bytes, other.store).fault == ImageFileFault::none);
    REQUIRE((written(other.store) == bytes));
    REQUIRE(same(other.store, one.store));
    rt::Archive counter = rt::Archive::measuring();
    one.store.archive(counter);
    REQUIRE(counter.status() == Status::ok);
    Bytes state(counter.bytes());
    rt::Archive writer = rt::Archive::writing(state);
    one.store.archive(writer);
    rt::Archive reader = rt::Archive::reading(state);
    third.store.archive(reader);
    REQUIRE(reader.status() == Status::ok);
    REQUIRE(same(third.store, one.store));
    rt::Archive short_of = rt::Archive::reading(std::span(state).first(state.size() - 1));
    third.store.archive(short_of);
    REQUIRE(short_of.status() != Status::ok);
    REQUIRE(third.store.images().empty());
  }
}

TEST_CASE("Damaged files of images are refused and leave the store empty") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  OwnedImages one(small(4)), other(small(4));
  put_way(one, 4, draws);
  const Bytes good = written(one.store);
  for (std::size_t keep = 0; keep < good.size(); keep += 1 + keep / 20) {
    const ImageFileFault fault = mapping::load_images(std::span(good).first(keep), other.store).fault;
    CHECK(fault == (keep < 8 ? ImageFileFault::no_images : ImageFileFault::length));
    CHECK(other.store.images().empty());
  }
  const auto any_byte = [&draws, &good](std::size_t first) {
    return first + static_cast<std::size_t>(draws.uniform(0, static_cast<double>(good.size() - first)));
  };
  // No bit can turn without notice: the checksum of a changed body is another one.
  for (int round = 0; round < 500; ++round) {
    Bytes bytes = good;
    bytes[any_byte(0)] ^= static_cast<std::uint8_t>(1 << static_cast<int>(draws.uniform(0, 8)));
    REQUIRE(mapping::load_images(bytes, other.store).fault != ImageFileFault::none);
    REQUIRE(other.store.images().empty());
  }
  // Whatever has the right checksum is refused or taken as it stands.
  for (int round = 0; round < 200; ++round) {
    Bytes bytes = good;
    for (int i = 0; i < 4; ++i) bytes[any_byte(24)] = static_cast<std::uint8_t>(draws.uniform(0, 256));
    bytes = sealed_images(bytes);
    if (mapping::load_images(bytes, other.store).fault != ImageFileFault::none) {
      REQUIRE(other.store.images().empty());
    } else {
      REQUIRE((written(other.store) == bytes));
    }
  }
}

TEST_CASE("A file of images is refused with its place and its reason") {
  OwnedImages one(small(4)), other(small(4)), little(small(1));
  put_at(one, 0, 0, 10);
  put_at(one, 10, 0, 10);
  const Bytes good = written(one.store);
  REQUIRE(good.size() == 24 + 2 * 6169 + 8);
  CHECK(std::string(good.begin(), good.begin() + 8) == "SOIMAGES");
  struct Damage {
    std::size_t at;
    std::uint8_t value;
    ImageFileFault fault;
    std::size_t byte;
  };
  const Damage damages[] = {{0, 'T', ImageFileFault::no_images, 0},
                            {8, 2, ImageFileFault::version, 0},
                            {12, 64, ImageFileFault::version, 0},
                            {16, 10, ImageFileFault::version, 0},
                            {20, 3, ImageFileFault::length, 0},
                            {23, 255, ImageFileFault::length, 0},
                            {24 + 15, 0, ImageFileFault::image, 24},  // the cosine is no longer one
                            {24 + 6169 + 3, 120, ImageFileFault::image, 24 + 6169}};
  for (const Damage& damage : damages) {
    INFO("byte " << damage.at);
    Bytes bytes = good;
    bytes[damage.at] = damage.value;
    const mapping::ImageFileResult result = mapping::load_images(sealed_images(bytes), other.store);
    CHECK(std::string(to_string(result.fault)) == to_string(damage.fault));
    CHECK(result.byte == damage.byte);
    CHECK(other.store.images().empty());
  }
  CHECK(mapping::load_images(good, little.store).fault == ImageFileFault::room);
}
