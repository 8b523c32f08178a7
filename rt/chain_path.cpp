// SPDX-License-Identifier: BSD-3-Clause
#include "rt/chain_path.hpp"

#include <cstring>

namespace sortie::rt {

namespace {

constexpr std::uint32_t kNone = ~0u;

std::uint32_t find_task(const Executive& executive, const char* name) {
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    if (std::strcmp(executive.task(i).name(), name) == 0) return i;
  }
  return kNone;
}

std::uint32_t find_stream(const Executive& executive, const char* name) {
  for (std::uint32_t i = 0; i < executive.stream_count(); ++i) {
    if (std::strcmp(executive.stream(i).name(), name) == 0) return i;
  }
  return kNone;
}

std::uint32_t place_in_group(const Executive& executive, std::uint32_t task) {
  const TaskBase& wanted = executive.task(task);
  const Group& group = executive.group(wanted.group());
  for (std::uint32_t i = 0; i < group.tasks.size(); ++i) {
    if (group.tasks[i] == &wanted) return i;
  }
  return kNone;
}

// The number of the group's port that `accepts`, or kNone.
template <class Ports, class Accept>
std::uint32_t find_port(const Ports& ports, Accept accepts) {
  for (std::uint32_t i = 0; i < ports.size(); ++i) {
    if (accepts(*ports[i])) return i;
  }
  return kNone;
}

}  // namespace

FoundPath find_chain(const Executive& executive, const char* const* steps, std::uint32_t count) {
  FoundPath found;
  const auto fail = [&found](PathFault fault, std::uint32_t step) {
    found.fault = fault;
    found.step = step;
    return found;
  };
  if (count == 0) return fail(PathFault::no_task, 0);
  const std::uint32_t stream = find_stream(executive, steps[0]);
  found.chain.from_stream = stream != kNone;
  std::uint32_t before = kNone;
  for (std::uint32_t step = found.chain.from_stream ? 1 : 0; step < count; ++step) {
    const std::uint32_t task = find_task(executive, steps[step]);
    if (task == kNone) return fail(PathFault::unknown, step);
    const std::uint16_t group = executive.task(task).group();
    bool backward = false;
    if (before != kNone && executive.task(before).group() == group) {
      backward = place_in_group(executive, before) >= place_in_group(executive, task);
      if (backward) ++found.chain.legs.back().jobs_back;
    } else {
      std::uint32_t port = 0;
      if (before != kNone) {
        port = find_port(executive.group(group).inputs,
                         [before](const InputBase& input) { return input.task() == before; });
        if (port == kNone) return fail(PathFault::not_read, step);
      } else if (found.chain.from_stream) {
        port = find_port(executive.group(group).streams,
                         [stream](const StreamBase& entry) { return entry.id() == stream; });
        if (port == kNone) return fail(PathFault::not_consumed, step);
      }
      if (!found.chain.legs.push_back({group, static_cast<std::uint16_t>(port), 0}))
        return fail(PathFault::too_long, step);
    }
    const ChainStep next{static_cast<std::uint16_t>(found.chain.legs.size() - 1),
                         static_cast<std::uint16_t>(place_in_group(executive, task)), backward};
    if (!found.chain.steps.push_back(next)) return fail(PathFault::too_long, step);
    before = task;
  }
  if (before == kNone) return fail(PathFault::no_task, 0);
  return found;
}

}  // namespace sortie::rt
