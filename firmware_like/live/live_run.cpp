// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/live_run.hpp"

#include "firmware_like/live/live_session.hpp"

namespace sortie::firmware {

LiveRunOutcome run_live(const VehicleRegistry& vehicles, const SimulatorFactory& simulator,
                        const LiveRunOptions& options) {
  LiveSession session(vehicles, simulator, options);
  session.run();
  return session.collect();
}

}  // namespace sortie::firmware
