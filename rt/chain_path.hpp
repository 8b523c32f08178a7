// SPDX-License-Identifier: BSD-3-Clause
// Finds a chain in an executive's table by the names of a stream and of tasks.
#pragma once

#include <cstdint>

#include "rt/chains.hpp"
#include "rt/executive.hpp"

namespace sortie::rt {

/// Why a path is no chain.
enum class PathFault : std::uint8_t {
  none,
  no_task,       ///< the path names no task at all
  unknown,       ///< step `step` is no task (the first: nor a stream) of this table
  not_consumed,  ///< the first step is a stream that the group of the second does not consume
  not_read,      ///< the group of step `step` has no input from the task of the step before
  too_long       ///< more than kMaxChainLegs changes of group, or kMaxChainSteps tasks
};

/// Result of find_chain().
struct FoundPath {
  PathFault fault{PathFault::none};
  std::uint32_t step{};
  Chain chain;  ///< good when there is no fault
};

/// Follows `count` names through the table. The first may be a stream or a task, the others are tasks. Within
/// a group a task that stands later in the table takes the value of the same job, an earlier one that of the
/// job before. From group to group there must be an input for exactly the task of the step before.
FoundPath find_chain(const Executive& executive, const char* const* steps, std::uint32_t count);

}  // namespace sortie::rt
