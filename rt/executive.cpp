// SPDX-License-Identifier: BSD-3-Clause
#include "rt/executive.hpp"

#include "rt/phases.hpp"

namespace sortie::rt {

GroupId Executive::add_group(const GroupSpec& spec) {
  const auto index = static_cast<std::uint16_t>(groups_.size());
  if (spec.period_ticks == 0) fail("a group's period must be at least one tick");
  if (spec.deadline_ticks > spec.period_ticks) fail("a group's deadline must not lie beyond its period");
  Group group;
  group.spec = spec;
  group.timing.period = spec.period_ticks == 0 ? 1 : spec.period_ticks;
  group.timing.deadline = spec.deadline_ticks == 0 ? group.timing.period : spec.deadline_ticks;
  if (spec.firm.k > 64 || spec.firm.m > spec.firm.k) fail("a firm promise needs m <= k <= 64");
  group.misses = MissWindow(spec.firm);
  if (groups_.push_back(group)) return GroupId{index};
  fail("too many groups");
  return GroupId{};  // what is added to it lies in a group that exists, and seal() refuses the whole
}

Status Executive::seal() {
  if (error_ == nullptr && groups_.size() == 0) error_ = "no groups: nothing would ever run";
  if (error_ != nullptr) return Status::out_of_range;
  ScheduleTable table = declared_table(*this);
  choose_phases(table);
  for (std::uint32_t i = 0; i < groups_.size(); ++i) groups_[i].timing.phase = table.groups[i].timing.phase;
  if (!allocate_channels()) {
    error_ = "arena full";
    return Status::full;
  }
  return Status::ok;
}

bool Executive::allocate_channels() {
  for (std::uint32_t writer = 0; writer < groups_.size(); ++writer) {
    Group& group = groups_[writer];
    group.record = make<JobRecord>("job records");
    std::uint32_t depth = 4;
    for (const Group& reader : groups_) {
      for (const InputBase* input : reader.inputs) {
        if (input->writer_group() != writer) continue;
        const std::uint32_t need = channel_depth(group.timing, reader.timing, input->history());
        depth = need > depth ? need : depth;
      }
    }
    const auto words = arena_.make_array<std::atomic<std::uint32_t>>("verdicts", depth);
    if (group.record == nullptr || words.empty()) return false;
    group.ledger = make<JobLedger>("verdicts", words.data(), depth);
    group.running = make<std::atomic<std::uint32_t>>("verdicts", 0u);
    if (group.ledger == nullptr || group.running == nullptr) return false;
    for (TaskBase* task : group.tasks) {
      bool is_read = false;
      for (const Group& reader : groups_) {
        for (const InputBase* input : reader.inputs) is_read = is_read || tasks_[input->task()] == task;
      }
      if (!is_read) continue;
      const auto slots = arena_.make_array<std::atomic<std::uint32_t>>(
          "channels", std::size_t{depth} * task->channel_words());
      if (slots.empty()) return false;
      task->attach_channel(*group.ledger, slots.data());
    }
    for (CommandOutletBase* outlet : group.outlets) {
      const auto slots = arena_.make_array<std::atomic<std::uint32_t>>(
          "outlets", std::size_t{depth} * outlet->channel_words());
      if (slots.empty()) return false;
      outlet->attach(*group.ledger, group.timing, slots.data());
    }
  }
  return true;
}

// What the ladder leaves of a task in this job. False: nothing, it is shed.
bool Executive::admit(const TaskBase& task, JobContext& context, const JobRecord* recorded) {
  JobRecord& record = *context.record_;
  const TaskSpec& spec = task.spec();
  const Service service = service_at(spec.criticality, record.level);
  context.granted_ = spec.units == 0 ? kUnlimitedUnits : spec.units;
  if (service == Service::reduced) {
    if (spec.units != 0)
      context.granted_ = spec.units / 2;
    else if (record.job % 2 != 0)
      return false;
  }
  if (service == Service::off) return false;
  context.limit_ = context.granted_;
  // Whether it is cut there shows when it asks for more (JobContext::spend).
  if (recorded != nullptr && ((recorded->cut >> context.task_) & 1u) != 0)
    context.limit_ = recorded->units[context.task_];
  return true;
}

void Executive::leave_out(TaskBase& task, JobContext& context) {
  JobRecord& record = *context.record_;
  record.shed = static_cast<std::uint16_t>(record.shed | (1u << context.task_));
  record.digest[context.task_] = 0;
  record.duration_ns[context.task_] = 0;
  ++task.shed_;
  task.hold(context);
}

bool Executive::note_skipped(std::uint32_t index, std::uint64_t count, Nanoseconds late_ns) {
  Group& group = groups_[index];
  const Nanoseconds period = static_cast<Nanoseconds>(group.timing.period) * base_tick_ns_;
  group.skipped += count;
  // Each release left out was later than the one after it. Of a very long pause several are counted with the
  // lateness of the first of them, so that the cost stays bounded and nothing looks better than it was.
  constexpr std::uint64_t kOneByOne = 256;
  const std::uint64_t stride = count / kOneByOne + 1;
  for (std::uint64_t i = 0; i < count; i += stride) {
    const Nanoseconds late = late_ns - static_cast<Nanoseconds>(i) * period;
    const auto ns = static_cast<std::uint64_t>(late > 0 ? late : 0);
    const std::uint64_t share = stride < count - i ? stride : count - i;
    group.lateness.record_many(ns, share);
    group.response.record_many(ns, share);
  }
  return group.misses.note_missed(count);
}

JobRecord& Executive::open_record(std::uint32_t index, std::uint64_t job, const JobOrder& order) {
  const Group& group = groups_[index];
  JobRecord& record = *group.record;
  record.tick = group.timing.release(job);
  record.job = job;
  record.group = static_cast<std::uint16_t>(index);
  record.streams = static_cast<std::uint8_t>(group.streams.size());
  record.inputs = static_cast<std::uint8_t>(group.inputs.size());
  record.tasks = static_cast<std::uint8_t>(group.tasks.size());
  record.field_bytes = 0;
  record.level = order.recorded != nullptr ? order.recorded->level : order.level;
  record.shed = 0;
  record.cut = 0;
  return record;
}

void Executive::latch(Group& group, JobRecord& record, const JobOrder& order) {
  for (std::uint32_t i = 0; i < group.streams.size(); ++i) {
    const std::uint32_t limit =
        order.recorded != nullptr ? order.recorded->stream[i].count : order.stream_limit;
    group.streams[i]->latch(record.tick, limit, record.stream[i]);
  }
  for (std::uint32_t i = 0; i < group.inputs.size(); ++i) {
    const InputRange* forced = order.recorded != nullptr ? &order.recorded->input[i] : nullptr;
    group.inputs[i]->latch(groups_[group.inputs[i]->writer_group()].timing, record.tick, forced,
                           record.input[i]);
  }
}

// Gives when the last of them ended.
Nanoseconds Executive::run_tasks(Group& group, JobRecord& record, const JobOrder& order) {
  JobContext context;
  context.tick = record.tick;
  context.job = record.job;
  context.release_ns = time_of(record.tick);
  context.period_ns = static_cast<Nanoseconds>(group.timing.period) * base_tick_ns_;
  context.due_ns = time_of(group.timing.due(record.job));
  context.record_ = &record;
  context.record_fields_ = record_fields_;
  context.digests_ = digests_;
  context.clock_ = clock_;
  context.clock_self_ = clock_self_;
  context.guard_ns_ = clock_ != nullptr ? order.guard_ns : 0;

  Nanoseconds before = now();
  record.started_ns = before;
  for (std::uint32_t i = 0; i < group.tasks.size(); ++i) {
    TaskBase& task = *group.tasks[i];
    context.task_ = i;
    record.units[i] = 0;
    if (!admit(task, context, order.recorded)) {
      leave_out(task, context);
      continue;
    }
    group.running->store(i + 1, std::memory_order_relaxed);
    if (task_probe_ != nullptr) [[unlikely]]
      task_probe_(task_probe_self_, task, record.tick, true);
    task.execute(context);
    if (task_probe_ != nullptr) [[unlikely]]
      task_probe_(task_probe_self_, task, record.tick, false);
    const Nanoseconds after = now();
    const auto spent = static_cast<std::uint64_t>(after > before ? after - before : 0);
    task.wall_time_.record(spent);
    if (spent > std::uint64_t{task.spec_.budget_us} * 1000u) ++task.over_budget_;
    task.cut_ += (record.cut >> i) & 1u;
    record.duration_ns[i] = spent > 0xffffffffu ? 0xffffffffu : static_cast<std::uint32_t>(spent);
    before = after;
  }
  return before;
}

Verdict Executive::run_job(std::uint32_t index, std::uint64_t job, const JobOrder& order) {
  Group& group = groups_[index];
  JobRecord& record = open_record(index, job, order);
  if (guard_ != nullptr) guard_(true);
  const bool opened = group.ledger->begin(job);
  latch(group, record, order);
  const Nanoseconds ended = run_tasks(group, record, order);
  const bool in_time = order.recorded != nullptr ? order.recorded->verdict == Verdict::done
                                                 : (order.due_ns == 0 || ended <= order.due_ns);
  for (CommandOutletBase* outlet : group.outlets) outlet->close(job);
  record.verdict = opened ? group.ledger->finish(job, in_time) : Verdict::missed;
  for (CommandOutletBase* outlet : group.outlets) outlet->settle(job, record.verdict);
  group.running->store(0, std::memory_order_relaxed);
  if (guard_ != nullptr) guard_(false);
  ++group.jobs;
  if (record.verdict == Verdict::missed) ++group.missed;
  group.misses.note(record.verdict != Verdict::missed);
  if (order.due_ns != 0) {
    const Nanoseconds release = time_of(record.tick);
    group.lateness.record(
        static_cast<std::uint64_t>(record.started_ns > release ? record.started_ns - release : 0));
    group.response.record(static_cast<std::uint64_t>(ended > release ? ended - release : 0));
  }
  if (sink_.call != nullptr) sink_.call(sink_.self, record);
  return record.verdict;
}

std::uint64_t Executive::digest() const {
  std::uint64_t chain = 0;
  for (std::uint32_t i = 0; i < tasks_.size(); ++i) chain = chain_digest(chain, i, tasks_[i]->chain());
  return chain;
}

ScheduleTable declared_table(const Executive& executive) {
  ScheduleTable table;
  table.base_tick_ns = executive.base_tick_ns();
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    const Group& group = executive.group(i);
    DeclaredGroup declared;
    declared.timing = group.timing;
    declared.core = group.spec.core;
    // Both hold as many as an executive does.
    for (const TaskBase* task : group.tasks) {
      static_cast<void>(declared.tasks.push_back(
          {std::uint64_t{task->budget_us()} * kNanosecondsPerMicrosecond, task->spec().criticality}));
    }
    static_cast<void>(table.groups.push_back(declared));
  }
  return table;
}

}  // namespace sortie::rt
