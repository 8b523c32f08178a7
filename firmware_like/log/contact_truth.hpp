// SPDX-License-Identifier: BSD-3-Clause
// The truth about contacts and flippers that a log of a simulation holds, for whoever judges an estimate by
// it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "rt/contact_truth.hpp"

namespace sortie::firmware {

class LogFile;

/// Calls `visit` with each record in the log's order, its stamp moved by `offset_ns` (clock_offset_ns() of
/// log_clock.hpp where the truth stands in another log than the run). Returns how many records are damaged;
/// those are left out. Memory: one record.
std::size_t for_each_contact_truth(const LogFile& log,
                                   const std::function<void(const rt::ContactTruth&)>& visit,
                                   std::int64_t offset_ns = 0);

/// A record without its points: what is drawn over a whole run.
struct ContactSummary {
  std::int64_t stamp_ns{};
  std::uint32_t contacts[rt::kVehicleParts]{};  ///< by rt::VehiclePart
  double load_n[rt::kVehicleParts]{};           ///< sum of their normal forces
  double flipper_asked_rad[rt::kFlippers]{};
  double flipper_angle_rad[rt::kFlippers]{};
  double flipper_torque_n_m[rt::kFlippers]{};
  std::uint32_t dropped{};
};

ContactSummary summarise(const rt::ContactTruth& truth);

/// Summaries of all records of a log.
std::vector<ContactSummary> contact_summaries(const LogFile& log, std::int64_t offset_ns = 0);

}  // namespace sortie::firmware
