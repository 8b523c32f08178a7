// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/commands/sweep_drives.hpp"

#include <cinttypes>
#include <cstdio>
#include <filesystem>

#include "firmware_like/bench/child_process.hpp"
#include "firmware_like/bench/sweep_folder.hpp"
#include "firmware_like/live_run.hpp"
#include "firmware_like/profile.hpp"
#include "firmware_like/program.hpp"
#include "firmware_like/text_format.hpp"
#include "rt/digest.hpp"

namespace sortie::firmware {

std::vector<SimulatedDrive> simulate_drives(const CommandContext& context, const DriveRequest& request,
                                            const std::string& folder) {
  std::filesystem::create_directories(folder);
  const std::string program = digest_of_file(own_program_path());
  std::vector<SimulatedDrive> drives;
  for (std::uint32_t seed = 1; seed <= request.seeds; ++seed) {
    LiveRunOptions run;
    run.scene = request.scene;
    run.overrides = request.overrides;
    if (request.seeds > 1) run.overrides.push_back("hil.seed=" + std::to_string(seed));
    run.seconds = request.seconds;
    run.virtual_time = true;
    run.lcm_url = "none";
    const Profile profile = load_scene(run.scene, run.overrides);
    const std::string source = program + " " + format_exact(request.seconds) + " " + profile.canonical();
    char identity[17];
    std::snprintf(identity, sizeof identity, "%016" PRIx64, rt::digest_bytes(source.data(), source.size()));
    const std::string name = folder + "/" + profile.name() +
                             (request.seeds > 1 ? "-seed" + std::to_string(seed) : "") + "-" + identity +
                             ".lcm";
    if (!std::filesystem::exists(name)) {
      run.record = name + own_suffix();
      static_cast<void>(run_live(context.parts.vehicles, context.parts.bench, run));
      std::filesystem::rename(run.record, name);
    }
    drives.push_back({name, identity});
  }
  return drives;
}

}  // namespace sortie::firmware
