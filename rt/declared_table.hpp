// SPDX-License-Identifier: BSD-3-Clause
// What an executive's groups and tasks declare, as the plain table that the analysis works on.
#pragma once

#include "rt/executive.hpp"
#include "rt/schedule.hpp"

namespace sortie::rt {

/// The table of `executive`, groups in their order. Before it is sealed all phases are 0.
ScheduleTable declared_table(const Executive& executive);

}  // namespace sortie::rt
