// SPDX-License-Identifier: BSD-3-Clause
// Keyframes that do not fit, that are cut off or damaged: refused, with the cure.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "rt/virtual_runner.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

TEST_CASE("keyframes of something else are refused with the cure") {
  const TempFolder folder;
  ReplayOptions options;
  options.from = "1";
  options.overrides = {"map.voxel_m=0.2"};
  CHECK(mentions(why(options), "another profile"));
  CHECK(mentions(why(options), "sortie index"));
  options.overrides.clear();

  options.keyframes = folder.file("absent");
  CHECK(mentions(why(options), "sortie index"));
  options.keyframes = hall().log;
  CHECK(mentions(why(options), "no file of keyframes"));

  const KeyframeFile good(keyframe_path(hall().log));
  const auto with = [&](const std::function<void(KeyframeHead&)>& edit) {
    KeyframeHead head = good.head();
    edit(head);
    options.keyframes = folder.file("edited.keyframes");
    KeyframeWriter writer(options.keyframes, head);
    writer.add(25, good.state(good.entries()[0]));
    writer.finish();
    return why(options);
  };
  CHECK(with([](KeyframeHead&) {}).empty());
  CHECK(mentions(with([](KeyframeHead& head) { head.version = "0.0.9"; }), "version 0.0.9"));
  CHECK(mentions(with([](KeyframeHead& head) { ++head.log_header_digest; }), "another log"));
  CHECK(mentions(with([](KeyframeHead& head) { --head.log_bytes; }), "bytes when the keyframes were made"));
  CHECK(mentions(with([](KeyframeHead& head) { head.tasks += "more"; }), "another profile"));
  CHECK(mentions(with([](KeyframeHead& head) { head.vehicle = "uav"; }), "another profile"));

  // A state that is whole and of another runtime: refused by its contents.
  KeyframeWriter writer(options.keyframes, good.head());
  writer.add(50, good.state(good.entries()[0]));
  writer.finish();
  CHECK(mentions(why(options), "another tick"));
  options.from = "9";
  CHECK(mentions(why(options), "nothing lies between"));
  for (const char* from : {"soon", "-1", "@", "1e300", "@1.5"}) {
    INFO(from);
    options.from = from;
    CHECK(mentions(why(options), "12.5"));
  }
}

TEST_CASE("a file of keyframes that is cut off or damaged is refused wherever that is") {
  const TempFolder folder;
  const std::string path = folder.file("hurt.keyframes");
  const KeyframeFile good(keyframe_path(hall().log));
  KeyframeWriter writer(folder.file("small.keyframes"), good.head());
  writer.add(25, good.state(good.entries()[0]));
  writer.add(50, good.state(good.entries()[1]));
  writer.finish();
  const std::string small = folder.file("small.keyframes");
  const std::uint64_t size = std::filesystem::file_size(small);
  const auto open_all = [&] {
    const KeyframeFile file(path);
    for (const KeyframeEntry& entry : file.entries()) static_cast<void>(file.state(entry));
  };
  std::vector<std::uint64_t> cuts;
  for (std::uint64_t cut = 0; cut < 1200; ++cut) cuts.push_back(cut);
  for (std::uint64_t cut = size - 60; cut < size; ++cut) cuts.push_back(cut);
  for (const std::uint64_t cut : cuts) {
    INFO("cut at byte " << cut << " of " << size);
    cut_file(small, path, cut);
    CHECK(mentions(message_of<InputError>(open_all), "sortie index"));
  }
  std::ifstream in(small, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  REQUIRE(whole.size() == size);
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 300; ++round) {
    std::string hurt = whole;
    const auto at = static_cast<std::size_t>(random() % (round < 100 ? 1200 : size));
    hurt[at] = static_cast<char>(static_cast<unsigned char>(hurt[at]) ^ (1u << (random() % 8)));
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(hurt.data(), static_cast<std::streamsize>(hurt.size()));
    out.close();
    REQUIRE(out.good());
    INFO("a bit of byte " << at << " turned");
    CHECK(mentions(message_of<InputError>(open_all), "sortie index"));
  }
}

TEST_CASE("a state of any content neither crashes nor passes unnoticed") {
  const LogFile log(hall().log);
  const auto& state = hall().full.states.at(1000);
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  int refused = 0;
  for (int round = 0; round < 40; ++round) {
    auto bad = state;
    if (round % 2 == 0) {
      for (int k = 0; k < 5; ++k) bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    } else {
      bad.resize(random() % bad.size());
    }
    Runtime runtime(Profile(log.header().scene_toml, "test", {}), own_vehicles(), RuntimeStart{});
    LogFeed feed(log, runtime, true);
    try {
      restore_state(bad, runtime, feed, 1000);
      rt::run_virtual(runtime.executive(), feed, 1000, 1050);
    } catch (const InputError&) {
      ++refused;
    }
  }
  CHECK(refused >= 20);
}
