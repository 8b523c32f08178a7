// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/plant_bench.hpp"

#include "firmware_like/bench/peer_program.hpp"

namespace sortie::firmware {

Json run_plant_bench(const PlantBenchOptions& options) {
  PeerProgram program{"sortie-bench-plant", options.program, {}, -1, options.passes};
  program.arguments = {"--rounds", std::to_string(options.rounds)};
  const auto pass = [&program](const char* option, const std::string& value) {
    if (!value.empty()) program.arguments.insert(program.arguments.end(), {option, value});
  };
  pass("--only", options.only);
  pass("--scene", options.scene);
  return run_peer_program(program);
}

}  // namespace sortie::firmware
