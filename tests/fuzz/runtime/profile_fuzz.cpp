// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: any text as a scene profile, as an override of one, and as a stored map. All that
// may come out is a profile or a ProfileError of one line that names the file; what is read lies in its
// range, and the canonical text of a profile is a profile again.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "firmware_like/parts/stored_cells.hpp"
#include "firmware_like/scene/profile.hpp"

using namespace sortie;
using namespace sortie::firmware;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void read(Profile& profile) {
  using Kind = ColumnSpec::Kind;
  const double number = profile.number("map.voxel_m", {0.1, 0.01, 10, "m", "edge"});
  require(number >= 0.01 && number <= 10);
  const std::int64_t whole = profile.integer("limits.voxels", {1024, 1, 262136, "", "voxels"});
  require(whole >= 1 && whole <= 262136);
  static_cast<void>(profile.flag("tasks.map.enabled", true, "scheduled"));
  const std::string choice = profile.text("map.policy", "euclidean", "which", {"euclidean", "smoothness"});
  require(choice == "euclidean" || choice == "smoothness");
  for (const auto& point : profile.points("mission.waypoints", 64, "driven to"))
    require(std::isfinite(point[0]) && std::isfinite(point[1]));
  for (const ProfileRow& row :
       profile.rows("world.boxes", {{"x_m", Kind::number, {0, -100, 100, "m"}, true}, {"name", Kind::text}},
                    64, "boxes")) {
    require(row.numbers.at("x_m") >= -100 && row.numbers.at("x_m") <= 100);
  }
  for (const ScriptLine& line : profile.script())
    require(std::isfinite(line.at_s) && std::isfinite(line.value));
  profile.refuse_unknown_keys();
}

void try_profile(const std::string& toml, const std::vector<std::string>& overrides) {
  try {
    Profile profile(toml, "fuzz.toml", overrides);
    const std::string canonical = profile.canonical();
    Profile again(canonical, "again.toml");
    require(again.canonical() == canonical && again.hash() == profile.hash());
    read(profile);
  } catch (const ProfileError& error) {
    const std::string words = error.what();
    require(!words.empty() && words.find('\n') == std::string::npos);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try_profile(text, {});
  try_profile("[scene]\nname = \"a\"\nvehicle = \"ugv\"\n", {text});
  try_profile("[scene]\nname = \"a\"\nvehicle = \"ugv\"\n" + text, {});
  try {
    const std::vector<CellState> cells = unpack_cells(text, 1000);
    require(cells.size() == 1000 && unpack_cells(pack_cells(cells), 1000) == cells);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
