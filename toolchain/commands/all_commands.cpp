// SPDX-License-Identifier: BSD-3-Clause
// Every command, and every benchmark, in the order of the help.
#include "firmware_like/doctor/doctor_command.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

void add_commands(firmware::Command& app, CommandContext& context) {
  add_run(app, context);
  add_plant(app, context);
  add_replay(app, context);
  add_check(app, context);
  add_diff(app, context);
  add_index(app, context);
  add_import(app, context);
  add_export(app, context);
  add_report(app, context);
  add_bench(app, context);
  add_merge(app, context);
  add_spy(app, context);
  add_set(app, context);
  add_drive(app, context);
  add_fly(app, context);
  add_scenes(app, context);
  firmware::add_doctor(app, context.chosen);
}

void add_bench(firmware::Command& app, CommandContext& context) {
  firmware::Command* command = app.add_subcommand(
      "bench", "Measure: sweep a profile's keys over logs, or one of the benchmarks below");
  command->footer(
      "Marks: * no other cell is as cheap and better, < what the profile says by itself.\n"
      "Examples:\n"
      "  sortie bench walk.lcm --scene building_walk --sweep map.voxel_m=0.05,0.1,0.2\n"
      "  sortie bench husky.lcm --scene skid_outdoor --align se2 --sweep groups.control.rate_hz=50,100,200 "
      "\\\n"
      "    --sweep attitude.acc_time_constant_s=2,3,4 --repeat 5 --out out/husky\n"
      "  sortie bench --scene ugv_hall --seeds 5 --seconds 20 --sweep map.voxel_m=0.1,0.2 --jobs 4 --out "
      "out/hall\n"
      "  sortie bench a.lcm b.lcm --sweep map.voxel_m=0.1,0.2 --slurm sweep.sh --out /shared/sweep\n"
      "  sortie bench --scene ugv_hall --scene uav_gusts --sweep knobs --out out/knobs");
  add_bench_sweep(*command, context);
  command->require_subcommand(0, 1);
  add_bench_all(*command, context);
  add_bench_peers(*command, context);
  add_bench_odometry(*command, context);
  add_bench_wcet(*command, context);
}

}  // namespace sortie::toolchain
