// SPDX-License-Identifier: BSD-3-Clause
// A live run on a system that gives it too few threads.
#include "tests/rt/few_threads.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "rt/posix/make_thread.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

TEST_CASE("a run that gets too few threads is refused with the cure, whichever it is that is missing") {
  const TempFolder folder;
  LiveRunOptions options;
  options.scene = stall_scene(folder);
  options.seconds = 0.05;
  options.realtime = false;
  options.lcm_url = "none";
  options.flight_ring.path = "none";
  // The child is another user, and comes to no file but this one.
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  stalls = {};
  // Its own, recorder, bench, devices, requests, housekeeper, two groups, supervisor.
  check_few_threads(10, 9, [&options] {
    try {
      return run_live(stall_vehicles(), nullptr, options).results.ticks == 50 ? 0 : 11;
    } catch (const rt::posix::ThreadRefused& error) {
      return mentions(error.what(), "cannot be made") && mentions(error.what(), "ulimit -u") ? 10 : 12;
    }
  });
}
