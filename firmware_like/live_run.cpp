// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live_run.hpp"

#include "firmware_like/live_session.hpp"

namespace sortie::firmware {

LiveRunOutcome run_live(const VehicleRegistry& vehicles, const BenchFactory& bench,
                        const LiveRunOptions& options) {
  LiveSession session(vehicles, bench, options);
  session.run();
  return session.collect();
}

}  // namespace sortie::firmware
