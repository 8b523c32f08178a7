// SPDX-License-Identifier: BSD-3-Clause
// The executive's state to bytes and back.
#include "rt/executive.hpp"

namespace sortie::rt {

namespace {
// Jobs that a group has released before `tick`.
std::uint64_t released_before(const GroupTiming& timing, Tick tick) {
  return tick <= timing.phase ? 0 : (tick - timing.phase - 1) / timing.period + 1;
}
}  // namespace

void Executive::archive(Archive& archive, Tick tick) {
  archive.expect(tick, "the state is of another tick");
  archive.expect(groups_.size(), "another number of groups");
  archive.expect(tasks_.size(), "another number of tasks");
  archive.expect(streams_.size(), "another number of streams");
  for (StreamBase* stream : streams_) stream->archive(archive);
  for (TaskBase* task : tasks_) task->archive(archive);
  for (Group& group : groups_) {
    Members(archive, group, group.spec.name)
        .fixed(group.spec, group.timing, group.tasks, group.streams, group.inputs, group.outlets)
        .fixed(group.ledger, group.record, group.running)
        .scratch(group.lateness, group.response)
        .state(group.jobs, group.missed, group.skipped, group.misses);
    archive.value(group.misses);
    for (InputBase* input : group.inputs) input->archive(archive);
    for (CommandOutletBase* outlet : group.outlets) outlet->archive(archive);
    group.ledger->archive(archive);
  }
  // Of a channel only what a reader may still take: inputs and verdicts, which decide it, are in place.
  for (std::uint32_t i = 0; i < tasks_.size(); ++i) {
    const Group& writer = groups_[tasks_[i]->group()];
    const std::uint64_t end = released_before(writer.timing, tick);
    std::uint64_t first = end;
    for (const Group& reader : groups_) {
      for (const InputBase* input : reader.inputs) {
        const auto wanted = static_cast<std::uint64_t>(input->considered() + 1);
        if (input->task() == i && wanted < first) first = wanted;
      }
    }
    const std::uint64_t depth = writer.ledger->depth();
    if (end > depth && first < end - depth) first = end - depth;
    tasks_[i]->archive_channel(archive, first, end);
  }
}

}  // namespace sortie::rt
