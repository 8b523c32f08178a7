// SPDX-License-Identifier: BSD-3-Clause
#include "rt/chain_path.hpp"

#include <cstring>

namespace sortie::rt {

namespace {

constexpr std::uint32_t kNone = ~0u;

// The first number below `count` that `accepts`, or kNone.
template <class Accept>
std::uint32_t find(std::uint32_t count, Accept accepts) {
  for (std::uint32_t i = 0; i < count; ++i) {
    if (accepts(i)) return i;
  }
  return kNone;
}

std::uint32_t place_in_group(const Executive& executive, std::uint32_t task) {
  const TaskBase& wanted = executive.task(task);
  const Group& group = executive.group(wanted.group());
  return find(group.tasks.size(), [&](std::uint32_t i) { return group.tasks[i] == &wanted; });
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
  const std::uint32_t stream = find(executive.stream_count(), [&](std::uint32_t i) {
    return std::strcmp(executive.stream(i).name(), steps[0]) == 0;
  });
  found.chain.from_stream = stream != kNone;
  std::uint32_t before = kNone;
  for (std::uint32_t step = found.chain.from_stream ? 1 : 0; step < count; ++step) {
    const std::uint32_t task = find(executive.task_count(), [&](std::uint32_t i) {
      return std::strcmp(executive.task(i).name(), steps[step]) == 0;
    });
    if (task == kNone) return fail(PathFault::unknown, step);
    const std::uint16_t number = executive.task(task).group();
    const Group& group = executive.group(number);
    bool backward = false;
    if (before != kNone && executive.task(before).group() == number) {
      backward = place_in_group(executive, before) >= place_in_group(executive, task);
      if (backward) ++found.chain.legs.back().jobs_back;
    } else {
      std::uint32_t port = 0;
      if (before != kNone) {
        port = find(group.inputs.size(), [&](std::uint32_t i) { return group.inputs[i]->task() == before; });
        if (port == kNone) return fail(PathFault::not_read, step);
      } else if (found.chain.from_stream) {
        port = find(group.streams.size(), [&](std::uint32_t i) { return group.streams[i]->id() == stream; });
        if (port == kNone) return fail(PathFault::not_consumed, step);
      }
      if (!found.chain.legs.push_back({number, static_cast<std::uint16_t>(port), 0}))
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
