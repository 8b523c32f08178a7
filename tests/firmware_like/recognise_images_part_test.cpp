// SPDX-License-Identifier: BSD-3-Clause
// A robot that goes by height images alone: where that places it, and images that are not those of the map.
#include <catch2/catch.hpp>

#include "rt/recognised_place.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/recognise_images_rig.hpp"

namespace sortie::testing {
namespace {

/// Images that are kept, each changed by `change(image, pose)`.
template <class Change>
void write_changed(const std::string& path, Change change) {
  std::vector<std::byte> memory(std::size_t{8} << 20);
  rt::Arena arena(memory);
  mapping::ImageStore kept({}, arena), changed({}, arena);
  REQUIRE(mapping::load_images(seen_images().bytes, kept).fault == mapping::ImageFileFault::none);
  for (const mapping::ImageRecord& record : kept.images()) {
    mapping::HeightImage image = record.image;
    mapping::KeyFramePose pose = record.pose;
    change(image, pose);
    REQUIRE(changed.take(image, pose, record.stamp_ms, record.robot) == Status::ok);
  }
  write(path, image_bytes(changed));
}

/// Left and right exchanged: a hall that was never seen.
mapping::HeightImage mirrored(const mapping::HeightImage& image) {
  mapping::HeightImage out;
  for (std::int32_t y = 0; y < mapping::ImagePlane::kCells; ++y) {
    for (std::int32_t x = 0; x < mapping::ImagePlane::kCells; ++x) {
      const std::int32_t other = mapping::ImagePlane::kCells - 1 - y;
      if (image.floor.at(x, y)) out.floor.set(x, other);
      if (image.low.at(x, y)) out.low.set(x, other);
      if (image.high.at(x, y)) out.high.set(x, other);
    }
  }
  return out;
}

/// A lost robot with these images, of which one look is enough: nothing places it.
firmware::LiveRunOutcome run_misled(const std::string& images) {
  firmware::KeptMapPaths kept = seen_images().kept;
  kept.images = images;
  firmware::LiveRunOutcome run = run_lost_by_images(40, "", kept, {"recognise_images.second_look_m=0"});
  CHECK(counted(run, "recognise_images_searches_begun") > 10);
  CHECK(counted(run, "recognise_images_recognised") == 0);
  CHECK(counted(run, "recognise_images_placed") == 0);
  CHECK(counted(run, "locate_accepted") == 0);
  return run;
}

}  // namespace

TEST_CASE("A lost robot is placed by height images alone, and replays to the bit from any keyframe",
          "[heavy]") {
  const TempFolder folder;
  const std::string log = folder.file("again.lcm");
  const firmware::Results& first = seen_images().outcome.results;
  CHECK(first.counters.at("recognise_images_drawn") > 50);
  CHECK(first.counters.at("recognise_images_kept_added") > 3);
  CHECK(first.counters.at("recognise_images_searches_begun") == 0);  // nothing is known

  const firmware::LiveRunOutcome run = run_turned(80, log, seen_images().kept, {});
  CHECK(run.failures.empty());
  CHECK(counted(run, "recognise_images_recognised") >= 3);
  CHECK(counted(run, "recognise_images_placed") == 1);
  CHECK(counted(run, "recognise_images_not_confirmed") == 0);
  CHECK(counted(run, "locate_unplaced_on_map") > 20);
  CHECK(counted(run, "locate_accepted") > 100);
  CHECK(error_of(run.results, "located_ate_max_m") < 0.15);
  if (rt::posix::kHeapTrapAvailable) CHECK(counted(run, "heap_calls") == 0);

  firmware::ReplayOptions options;
  options.maps.map = seen_images().kept.map;
  CHECK(mentions(message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, options)); }),
                 "begins with the images hall.images"));
  options.maps = seen_images().kept;
  const Indexed indexed =
      replay_and_keep(log, firmware::own_vehicles(), options, 4000, firmware::keyframe_path(log));
  CHECK(indexed.outcome.results.digest == run.results.digest);
  for (const char* const from : {"5.05", "11.35", "23.55"}) {
    INFO("from " << from);
    options.from = from;
    const firmware::ReplayOutcome part = replay_log(log, options);
    CHECK(complaint_of(part).empty());
    CHECK(part.results.digest == run.results.digest);
  }
}

TEST_CASE("Images that a run keeps are the same from any keyframe on", "[heavy]") {
  const TempFolder folder;
  firmware::ReplayOptions options;
  options.overrides = kImagesAlone;
  options.keyframes = folder.file("first.keyframes");
  const Indexed indexed =
      replay_and_keep(seen_hall().log, firmware::own_vehicles(), options, 4000, options.keyframes);
  CHECK(indexed.outcome.results.digest == seen_images().outcome.results.digest);
  for (const char* const from : {"0.35", "23.55", "50.05"}) {
    INFO("from " << from);
    options.from = from;
    const firmware::ReplayOutcome part = replay_log(seen_hall().log, options);
    CHECK(part.results.digest == indexed.outcome.results.digest);
    CHECK((image_bytes(*part.runtime->vehicle().images()) == seen_images().bytes));
  }
}

TEST_CASE("Both channels of recognition answer beside each other, each under its own name", "[heavy]") {
  firmware::KeptMapPaths kept = seen_images().kept;
  kept.targets = seen_hall().kept.targets;
  const firmware::LiveRunOutcome both =
      run_lost(25, "",
               {"tasks.recognise_images.enabled=true", "tasks.recognise_images.budget_us=3000",
                "recognise_images.units=2000000"},
               kept);
  const firmware::LiveRunOutcome segments = run_lost(25, "", {});
  CHECK(both.failures.empty());
  CHECK(counted(both, "recognise_images_searches_begun") > 3);  // of 4 s each, with so few units
  CHECK(counted(both, "recognise_searches_begun") == counted(segments, "recognise_searches_begun"));
  CHECK(counted(both, "recognise_recognised") == counted(segments, "recognise_recognised"));
  CHECK(segments.results.counters.count("recognise_images_drawn") == 0);  // left out: nothing of it
}

TEST_CASE("Images of another hall, or of another map of this one, place nobody", "[heavy]") {
  const TempFolder folder;
  const std::string images = folder.file("other.images");
  write_changed(images, [](mapping::HeightImage& image, mapping::KeyFramePose&) { image = mirrored(image); });
  CHECK(counted(run_misled(images), "recognise_images_searches_unlike") > 10);

  // The map's origin is elsewhere: images find their place, and the scan says that it is not there.
  write_changed(images, [](mapping::HeightImage&, mapping::KeyFramePose& pose) { pose.place.x += 300; });
  const firmware::LiveRunOutcome run = run_misled(images);
  CHECK(counted(run, "recognise_images_searches_found") >= 2);
  CHECK(counted(run, "recognise_images_refused") >= 2);
}

TEST_CASE("A place by images that no scan can be held against is not verified", "[heavy]") {
  const firmware::LiveRunOutcome run =
      run_lost_by_images(40, "", seen_images().kept, {"locate.max_range_m=1"});
  CHECK(counted(run, "recognise_images_unverified") >= 2);
  CHECK(counted(run, "recognise_images_recognised") + counted(run, "recognise_images_refused") == 0);
  CHECK(counted(run, "recognise_images_placed") == 0);
}

}  // namespace sortie::testing
