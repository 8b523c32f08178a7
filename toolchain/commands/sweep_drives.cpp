// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/sweep_drives.hpp"

#include <filesystem>

#include "firmware_like/live/live_run.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/sweep/sweep_folder.hpp"

namespace sortie::toolchain {

std::vector<SimulatedDrive> simulate_drives(const CommandContext& context, const DriveRequest& request,
                                            const std::string& folder) {
  std::filesystem::create_directories(folder);
  const std::string program = digest_of_file(own_program_path());
  std::string maps;
  firmware::KeptMapPaths::fields(request.maps, [&maps](const char* name, const std::string& path) {
    if (!path.empty()) maps += std::string(name) + " " + digest_of_file(path) + " ";
  });
  std::vector<SimulatedDrive> drives;
  for (const std::string& scene : request.scenes) {
    for (std::uint32_t seed = 1; seed <= request.seeds; ++seed) {
      firmware::LiveRunOptions run;
      run.scene = scene;
      run.overrides = request.overrides;
      run.maps = request.maps;
      if (request.seeds > 1) run.overrides.push_back("hil.seed=" + std::to_string(seed));
      run.seconds = request.seconds;
      run.virtual_time = true;
      run.lcm_url = "none";
      const firmware::Profile profile = firmware::load_scene(run.scene, run.overrides);
      const std::string identity = hex_digest(program + " " + firmware::format_exact(request.seconds) + " " +
                                              maps + profile.canonical());
      const std::string name = folder + "/" + profile.name() +
                               (request.seeds > 1 ? "-seed" + std::to_string(seed) : "") + "-" + identity +
                               ".lcm";
      if (!std::filesystem::exists(name)) {
        run.record = name + own_suffix();
        static_cast<void>(firmware::run_live(context.parts.vehicles, context.parts.simulator, run));
        std::filesystem::rename(run.record, name);
      }
      drives.push_back({name, identity});
    }
  }
  return drives;
}

}  // namespace sortie::toolchain
