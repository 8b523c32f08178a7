// SPDX-License-Identifier: BSD-3-Clause
// Judges a scene's declared table before anything runs: what cannot be on time is refused, with the cures.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/result/results_schedule.hpp"
#include "firmware_like/scene/profile.hpp"
#include "rt/executive.hpp"
#include "rt/schedule_report.hpp"

namespace sortie::firmware {

/// A table that may run.
struct ScheduleCheck {
  rt::ScheduleTable table;
  rt::ScheduleReport report;
  std::vector<std::string> warnings;  ///< overload that was accepted, processors that are nearly full
};

/// Analyses a sealed executive. Throws ProfileError when a group can be late by its declared budgets, unless
/// [schedule] accept_overload says that this is wanted.
ScheduleCheck check_schedule(Profile& profile, const rt::Executive& executive);

/// The same for people: with names and in microseconds.
ScheduleResult schedule_result(const ScheduleCheck& check, const rt::Executive& executive);

}  // namespace sortie::firmware
