// SPDX-License-Identifier: BSD-3-Clause
// Keys that are marked as knobs where they are declared, and the table of knobs.
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "tests/firmware_like/run_support.hpp"
#include "toolchain/bench/knob_table.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

TEST_CASE("the keys that are marked as knobs, over all scenes, are those of the table") {
  std::set<std::string> marked;
  for (const BuiltInScene& scene : built_in_scenes()) {
    const Runtime runtime(load_scene(scene.name), own_vehicles(), RuntimeStart{});
    for (const ProfileKey& key : runtime.profile().keys()) {
      if (key.is_knob) marked.insert(key.path);
    }
  }
  std::set<std::string> listed;
  for (const Knob& knob : algorithm_knobs()) listed.insert(knob.key);
  CHECK(marked == listed);
}
