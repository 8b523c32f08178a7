// SPDX-License-Identifier: BSD-3-Clause
// A robot comes back to a hall that another run has seen, from the other side: what it recognises, and where
// that places it.
#include <catch2/catch.hpp>

#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/recognise_rig.hpp"

namespace sortie::testing {

TEST_CASE("A lost robot recognises a hall that it drives through the other way round, and replays to the bit",
          "[heavy]") {
  const TempFolder folder;
  const firmware::LiveRunOutcome& first = seen_hall().run;
  const firmware::KeptMapPaths& seen = seen_hall().kept;
  const std::string log = folder.file("again.lcm");
  CHECK(first.failures.empty());
  CHECK(counted(first, "recognise_targets_added") > 20);
  CHECK(counted(first, "recognise_searches_begun") == 0);  // nothing is known
  CHECK((target_bytes(*replay_log(seen_hall().log, {}).runtime) == seen_hall().bytes));

  const firmware::LiveRunOutcome run = run_lost(40, log, {});
  CHECK(run.failures.empty());
  CHECK(counted(run, "recognise_recognised") >= 3);
  CHECK(counted(run, "recognise_refused") == 0);
  CHECK(counted(run, "recognise_placed") == 1);
  CHECK(counted(run, "recognise_not_confirmed") == 0);
  CHECK(counted(run, "locate_unplaced_on_map") > 20);
  CHECK(counted(run, "locate_accepted") > 100);
  CHECK(error_of(run.results, "located_ate_max_m") < 0.15);
  if (rt::posix::kHeapTrapAvailable) CHECK(counted(run, "heap_calls") == 0);

  firmware::ReplayOptions options;
  CHECK(mentions(message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, options)); }),
                 "begins with the map hall.surfels"));
  options.maps.map = seen.map;
  CHECK(mentions(message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, options)); }),
                 "begins with the targets hall.targets"));
  options.maps = seen;
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

TEST_CASE("A place that no scan confirms is taken back, and a lost robot is placed again", "[heavy]") {
  // The judge finds that scans fit; the locator is told that none does.
  const firmware::LiveRunOutcome run =
      run_lost(25, "", {"locate.least_share=1", "recognise.second_look_m=0"});
  const std::uint64_t placed = counted(run, "recognise_placed");
  CHECK(placed >= 2);
  CHECK(counted(run, "recognise_not_confirmed") + 1 >= placed);
  CHECK(counted(run, "locate_accepted") == 0);
  CHECK(counted(run, "locate_unplaced_on_map") + 6 * placed > counted(run, "locate_in"));
}

TEST_CASE("A place that no scan can be held against is not verified, and the next search begins", "[heavy]") {
  const firmware::LiveRunOutcome run = run_lost(25, "", {"locate.max_range_m=1"});
  CHECK(counted(run, "recognise_unverified") >= 2);
  CHECK(counted(run, "recognise_recognised") + counted(run, "recognise_refused") == 0);
  CHECK(counted(run, "recognise_searches_begun") > 10);
}

TEST_CASE("targets that cannot be used are refused with their cure") {
  const TempFolder folder;
  const std::string nothing = folder.file("nothing.targets"), text = folder.file("text.targets"),
                    cut = folder.file("cut.targets");
  write(text, std::vector<std::uint8_t>(40, 'x'));
  std::vector<std::byte> memory(1 << 20);
  rt::Arena arena(memory);
  mapping::TargetStore store({}, arena);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::target_file_bytes(store)));
  REQUIRE(mapping::write_targets(store, bytes) == Status::ok);
  bytes.pop_back();
  write(cut, bytes);
  const auto refused = [&](const firmware::KeptMapPaths& maps, const std::vector<std::string>& more) {
    return message_of<std::runtime_error>([&] { static_cast<void>(run_recognising(1, "", maps, more)); });
  };
  CHECK(mentions(refused({"", nothing, ""}, {}),
                 "cannot be read; make it with `sortie export targets LOG -o FILE`"));
  CHECK(mentions(refused({"", text, ""}, {}), "holds no targets"));
  CHECK(mentions(refused({cut, "", ""}, {}), "give it with --targets"));
  CHECK(mentions(refused({"", cut, ""}, {}), "cut off, or too long"));
  CHECK(mentions(refused({"", cut, ""}, {"tasks.recognise.enabled=false"}), "tasks.recognise.enabled=true"));
  CHECK(mentions(refused({}, {"map.segments=off"}), "map.segments=euclidean"));
}

}  // namespace sortie::testing
