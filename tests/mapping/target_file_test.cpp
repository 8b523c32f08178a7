// SPDX-License-Identifier: BSD-3-Clause
// Targets that are kept from one run to another, and files that are none.
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <string>

#include "mapping/recognition/consistency_sweep.hpp"
#include "mapping/recognition/target_file.hpp"
#include "rt/digest.hpp"
#include "tests/mapping/target_rig.hpp"

namespace {
using namespace sortie;
using mapping::TargetFileFault;
using testing::TargetEvent;

using Bytes = std::vector<std::uint8_t>;

// One target that is farther would end every search that comes upon it.
static_assert(mapping::KeyFramePose::kFarthestCm + 2 * mapping::kFarthestOffsetCm <=
              mapping::ConsistencySweep::kMostPlaceCm);

mapping::TargetStoreConfig file_config() {
  mapping::TargetStoreConfig config;
  config.targets = 120;
  config.key_frames = 7;
  return config;
}

Bytes written(const mapping::TargetStore& store) {
  Bytes bytes(static_cast<std::size_t>(mapping::target_file_bytes(store)));
  REQUIRE(mapping::write_targets(store, std::span(bytes).first(bytes.size() - 1)) == Status::full);
  REQUIRE(mapping::write_targets(store, bytes) == Status::ok);
  return bytes;
}

void finish_work(mapping::TargetStore& store) {
  std::uint64_t units = ~0ull / 2;
  REQUIRE(store.run(units));
}

/// With the right checksum again.
Bytes sealed(Bytes bytes) {
  const std::uint64_t check = rt::digest_bytes(bytes.data(), bytes.size() - 8);
  std::memcpy(&bytes[bytes.size() - 8], &check, 8);
  return bytes;
}

/// Key frames 0 and 1, three targets.
void put_three(mapping::TargetStore& store) {
  for (std::uint16_t k = 0; k < 2; ++k) REQUIRE(store.set_key_frame(k, {}) == Status::ok);
  for (std::uint32_t id = 0; id < 3; ++id) {
    mapping::TargetSighting seen;
    seen.id = id;
    seen.offset = {1000 * static_cast<std::int32_t>(id), 0, 0};
    REQUIRE(store.put(seen).added);
  }
}

}  // namespace

TEST_CASE("Targets come back from their file as they were kept") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  for (int round = 0; round < 30; ++round) {
    INFO("round " << round);
    testing::OwnedTargets one(file_config()), other(file_config());
    for (const TargetEvent& event : draws.stream(one.store.config(), draws.whole(0, 400)))
      testing::happens(one.store, event);
    for (const TargetEvent& event : draws.stream(one.store.config(), 50))
      testing::happens(other.store, event);
    finish_work(one.store);
    const Bytes bytes = written(one.store);
    REQUIRE(mapping::load_targets(bytes, other.store).fault == TargetFileFault::none);
    REQUIRE((written(other.store) == bytes));
    REQUIRE(other.store.kept() == one.store.kept());
    finish_work(other.store);
    REQUIRE((written(other.store) == bytes));  // what is told anew is what was kept
    std::size_t at = 0;
    for (std::size_t i = 0; i < one.store.records().size(); ++i) {
      if (one.store.records()[i].state == mapping::TargetState::free) continue;
      REQUIRE(other.store.places()[at] == one.store.places()[i]);
      REQUIRE(other.store.records()[at++].id == one.store.records()[i].id);
    }
  }
}

TEST_CASE("Damaged files of targets are refused and leave the store empty") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  testing::OwnedTargets one(file_config()), other(file_config());
  for (const TargetEvent& event : draws.stream(one.store.config(), 300)) testing::happens(one.store, event);
  const Bytes good = written(one.store);
  const auto is_empty = [&other] {
    return other.store.records().empty() && other.store.kept() == 0 && !other.store.key_frames().knows(0);
  };
  for (std::size_t keep = 0; keep < good.size(); keep += 1 + keep / 20) {
    const TargetFileFault fault = mapping::load_targets(std::span(good).first(keep), other.store).fault;
    CHECK(fault == (keep < 8 ? TargetFileFault::no_targets : TargetFileFault::length));
    CHECK(is_empty());
  }
  // No bit can turn without notice: the checksum of a changed body is another one.
  for (int round = 0; round < 500; ++round) {
    Bytes bytes = good;
    const auto at = static_cast<std::size_t>(draws.whole(0, static_cast<std::int32_t>(good.size()) - 1));
    bytes[at] ^= static_cast<std::uint8_t>(1 << draws.whole(0, 7));
    REQUIRE(mapping::load_targets(bytes, other.store).fault != TargetFileFault::none);
    REQUIRE(is_empty());
  }
  // Whatever has the right checksum is refused or taken, and then it can be worked with.
  for (int round = 0; round < 500; ++round) {
    Bytes bytes = good;
    for (int i = 0; i < 4; ++i)
      bytes[static_cast<std::size_t>(draws.whole(24, static_cast<std::int32_t>(good.size()) - 1))] =
          draws.byte(0, 255);
    if (mapping::load_targets(sealed(bytes), other.store).fault != TargetFileFault::none) REQUIRE(is_empty());
    finish_work(other.store);
  }
}

TEST_CASE("A file of targets is refused with its place and its reason") {
  testing::OwnedTargets one(file_config()), other(file_config());
  put_three(one.store);
  const Bytes good = written(one.store);
  const std::size_t frames = 24, targets = frames + 2 * 22;
  REQUIRE(good.size() == targets + 3 * 56 + 8);
  CHECK(std::string(good.begin(), good.begin() + 8) == "SOTARGET");

  struct Damage {
    std::size_t at;
    std::uint8_t value;
    TargetFileFault fault;
    std::size_t byte;
  };
  const Damage damages[] = {
      {0, 'T', TargetFileFault::no_targets, 0},
      {8, 2, TargetFileFault::version, 0},
      {12, 23, TargetFileFault::version, 0},
      {16, 3, TargetFileFault::length, 0},
      {23, 255, TargetFileFault::length, 0},
      {frames + 22, 0, TargetFileFault::order, frames + 22},
      {frames + 22, 7, TargetFileFault::key_frames_room, frames + 22},
      {frames + 17, 0, TargetFileFault::key_frame, frames},  // the cosine is no longer one
      {targets + 24, 1, TargetFileFault::twice, targets + 56},
      {targets + 39, 1, TargetFileFault::target, targets},            // 168 km away
      {targets + 56 + 48, 2, TargetFileFault::target, targets + 56},  // of no key frame
      {targets + 52, 0, TargetFileFault::target, targets},            // never seen
  };
  for (const Damage& damage : damages) {
    INFO("byte " << damage.at);
    Bytes bytes = good;
    bytes[damage.at] = damage.value;
    const mapping::TargetFileResult result = mapping::load_targets(sealed(bytes), other.store);
    CHECK(std::string(to_string(result.fault)) == to_string(damage.fault));
    CHECK(result.byte == damage.byte);
    CHECK(other.store.kept() == 0);
    CHECK_FALSE(other.store.key_frames().knows(0));
    if (damage.fault == TargetFileFault::key_frames_room) CHECK(result.needed == 8);
  }
  mapping::TargetStoreConfig config = file_config();
  config.targets = 2;
  testing::OwnedTargets little(config);
  const mapping::TargetFileResult result = mapping::load_targets(good, little.store);
  CHECK(result.fault == TargetFileFault::targets_room);
  CHECK(result.needed == 3);
  config.targets = 3;
  testing::OwnedTargets enough(config);
  CHECK(mapping::load_targets(good, enough.store).fault == TargetFileFault::none);
}
