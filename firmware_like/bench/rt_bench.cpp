// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/rt_bench.hpp"

#include "firmware_like/bench/peer_program.hpp"

namespace sortie::firmware {

Json run_rt_bench(const RtBenchOptions& options) {
  PeerProgram program{"sortie-bench-rt", options.program, {}, options.core, options.passes, true};
  program.arguments = {"--rounds", std::to_string(options.rounds), "--slice", std::to_string(options.slice_s),
                       "--load",   std::to_string(options.load)};
  if (options.core >= 0)
    program.arguments.insert(program.arguments.end(), {"--core", std::to_string(options.core)});
  if (!options.only.empty()) program.arguments.insert(program.arguments.end(), {"--only", options.only});
  return run_peer_program(program);
}

}  // namespace sortie::firmware
