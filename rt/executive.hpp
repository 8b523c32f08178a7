// SPDX-License-Identifier: BSD-3-Clause
// The executive: a static table of groups and tasks, checked when it is sealed, and the one way in which a
// job runs. Who calls run_job, and when, is the business of a runner: live threads, a virtual clock on one
// thread, or a virtual clock with one worker a group. Outputs are the same in all of them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <utility>

#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/command_outlet.hpp"
#include "rt/fixed_vector.hpp"
#include "rt/limits.hpp"
#include "rt/miss_window.hpp"
#include "rt/pooled_stream.hpp"
#include "rt/ports.hpp"
#include "rt/task.hpp"

namespace sortie::rt {

struct ScheduleTable;

/// What a live run does with releases of a group whose time has passed.
enum class OverrunPolicy : std::uint8_t {
  skip,      ///< leaves out whole periods, keeps the phase; waiting samples go to the next job
  catch_up,  ///< runs up to `catch_up` of them late, one after the other, then leaves out: for streams that
             ///< come in bursts. Late outputs are missed all the same.
  stop       ///< ends the run: for groups that must never be late
};

/// What a group is asked to be. Periods and deadlines in base ticks.
struct GroupSpec {
  const char* name{};
  std::uint32_t period_ticks{1};
  std::uint32_t deadline_ticks{};  ///< 0: the period. Outputs become visible to other groups then.
  int core{-1};                    ///< processor to pin a live worker to, or -1
  OverrunPolicy policy{OverrunPolicy::skip};
  std::uint32_t catch_up{};  ///< most late releases in a row that are still run
  FirmPromise firm{};        ///< how many releases of how many are met; broken promises are counted
};

/// Handle of a group.
struct GroupId {
  std::uint16_t index{};
};

/// A group at run time. Statistics belong to the thread that runs the group until the run is over.
struct Group {
  GroupSpec spec;
  GroupTiming timing;
  FixedVector<TaskBase*, kMaxTasksPerGroup> tasks;
  FixedVector<StreamBase*, kMaxStreamsPerGroup> streams;
  FixedVector<InputBase*, kMaxInputsPerGroup> inputs;
  FixedVector<CommandOutletBase*, kMaxOutletsPerGroup> outlets;
  JobLedger* ledger{};
  JobRecord* record{};
  LatencyHistogram lateness;  ///< live: start of the job after its release
  LatencyHistogram response;  ///< live: end of the job after its release
  std::uint64_t jobs{};
  std::uint64_t missed{};
  std::uint64_t skipped{};
  MissWindow misses;  ///< releases that were missed or skipped
  /// 1 + the index within the group of the task that runs now, or 0. For a watchdog on another thread.
  std::atomic<std::uint32_t>* running{};
};

/// Where finished jobs go. Called on the thread that ran the job; must not block in a live run.
struct JobSink {
  void* self{};
  void (*call)(void* self, const JobRecord& record){};
};

/// How one job is to run.
struct JobOrder {
  const JobRecord* recorded{};      ///< replay: take exactly what this job took, with its verdict
  std::uint32_t stream_limit{~0u};  ///< most samples taken from each stream
  Nanoseconds due_ns{};    ///< live: the deadline on the run's clock; 0: the job is in time by definition
  Nanoseconds guard_ns{};  ///< live: when anytime tasks are cut, on the run's clock; 0: never
  std::uint8_t level{};    ///< live: level of the degrade ladder
};

/// The table and the state of a run. Everything is built before seal(); afterwards nothing allocates.
class Executive {
 public:
  /// Monotonic run clock, read for statistics and for live deadlines only.
  using Clock = JobContext::Clock;

  /// All memory comes from `arena`. `base_tick_ns`: length of a tick. `epoch`: run clock at tick 0.
  Executive(Arena& arena, Nanoseconds base_tick_ns, Nanoseconds epoch_ns)
      : arena_(arena), base_tick_ns_(base_tick_ns), epoch_ns_(epoch_ns) {}

  /// Adds a group. Order of addition is the order of ties, everywhere.
  GroupId add_group(const GroupSpec& spec);

  /// Adds a stream that group `reader` consumes. `capacity` must be a power of two; `batch` <= capacity.
  template <class T>
  Stream<T>* add_stream(GroupId reader, const char* name, std::uint32_t capacity, std::uint32_t batch) {
    const std::span<T> ring = arena_.make_array<T>(name, capacity);
    const std::span<T> taken = arena_.make_array<T>("batches", batch);
    auto* stream = make<Stream<T>>("streams", name, static_cast<std::uint16_t>(streams_.size()), ring.data(),
                                   capacity, taken.data(), batch);
    if (ring.empty() || taken.empty() || stream == nullptr) return fail("arena full");
    if (!streams_.push_back(stream) || !groups_[reader.index].streams.push_back(stream))
      return fail("too many streams");
    return stream;
  }

  /// Adds a stream of big samples: `slots` buffers of `slot_size` elements each; at most slots / 2 are taken
  /// by one job, so that the job before and the job now both keep theirs.
  template <class Header, class Element>
  PooledStream<Header, Element>* add_pooled_stream(GroupId reader, const char* name, std::uint32_t slots,
                                                   std::uint32_t slot_size) {
    using Pooled = PooledStream<Header, Element>;
    const std::uint32_t ring = std::bit_ceil(slots < 2 ? 2u : slots);
    const std::uint32_t batch = slots < 2 ? 1 : slots / 2;
    const auto elements = arena_.make_array<Element>(name, static_cast<std::size_t>(slots) * slot_size);
    const auto tickets = arena_.make_array<typename Pooled::Ticket>("streams", ring);
    const auto free_slots = arena_.make_array<std::uint32_t>("streams", ring);
    const auto taken = arena_.make_array<typename Pooled::Ticket>("batches", batch);
    if (elements.empty() || tickets.empty() || free_slots.empty() || taken.empty()) return fail("arena full");
    auto* stream =
        make<Pooled>("streams", name, static_cast<std::uint16_t>(streams_.size()), elements.data(), slots,
                     slot_size, tickets.data(), free_slots.data(), ring, taken.data(), batch);
    if (stream == nullptr) return fail("arena full");
    if (!streams_.push_back(stream) || !groups_[reader.index].streams.push_back(stream))
      return fail("too many streams");
    return stream;
  }

  /// Adds a task at the end of a group. `function(JobContext&, T& output)` fills the output at every release.
  template <Described T, class F>
  Task<T>* add_task(GroupId group, const TaskSpec& spec, F function) {
    auto* task = make<FunctionTask<T, F>>("tasks", spec, group.index, std::move(function));
    if (task == nullptr) return fail("arena full");
    if (!tasks_.push_back(task) || !groups_[group.index].tasks.push_back(task)) return fail("too many tasks");
    return task;
  }

  /// The same for a task of criticality A without work units.
  template <Described T, class F>
  Task<T>* add_task(GroupId group, const char* name, std::uint32_t budget_us, F function) {
    return add_task<T>(group, TaskSpec{name, budget_us}, std::move(function));
  }

  /// Lets group `reader` read `task` of another group. `history`: how many jobs back it may look (>= 1).
  template <Described T>
  Input<T>* add_input(GroupId reader, const Task<T>* task, std::uint32_t history) {
    if (task == nullptr) return nullptr;
    const std::span<T> values = arena_.make_array<T>("inputs", history);
    std::uint16_t index = 0;
    while (tasks_[index] != task) ++index;
    auto* input = make<Input<T>>("inputs", task->group(), index, history, values.data(), task->channel());
    if (values.empty() || input == nullptr) return fail("arena full");
    if (!groups_[reader.index].inputs.push_back(input)) return fail("too many inputs");
    return input;
  }

  /// A way out for the commands of `group`'s tasks (rt/command_outlet.hpp).
  template <class T>
  CommandOutlet<T>* add_outlet(GroupId group) {
    auto* outlet = make<CommandOutlet<T>>("outlets", base_tick_ns_, epoch_ns_);
    if (outlet == nullptr) return fail("arena full");
    if (!groups_[group.index].outlets.push_back(outlet)) return fail("too many outlets");
    return outlet;
  }

  /// Checks the table, chooses phases, allocates channels. Status: ok, out_of_range or full; see error().
  Status seal();
  /// Why the set-up failed, or null.
  const char* error() const { return error_; }

  /// Runs one job to its end and gives its verdict. The caller keeps the order of a group's jobs and runs
  /// each group on one thread at a time. Real-time safe.
  Verdict run_job(std::uint32_t group, std::uint64_t job, const JobOrder& order);

  void set_sink(JobSink sink) { sink_ = sink; }
  void set_clock(Clock clock, void* self) {
    clock_ = clock;
    clock_self_ = self;
  }
  /// Called with true before a job's first task and with false after its last: to arm traps. Null: off.
  void set_guard(void (*guard)(bool entering)) { guard_ = guard; }
  /// Called with true just before and with false just after each task: to count what it costs. Null: off.
  using TaskProbe = void (*)(void* self, const TaskBase& task, Tick tick, bool entering);
  void set_task_probe(TaskProbe probe, void* self) {
    task_probe_ = probe;
    task_probe_self_ = self;
  }
  void set_record_fields(bool on) { record_fields_ = on; }
  /// Digests are on unless a run will never be compared with another.
  void set_digests(bool on) { digests_ = on; }
  /// Live: notes releases that were left out after an overrun, `late_ns` being the lateness of the first;
  /// they count as late in the histograms and as missed. Gives true when a promise (GroupSpec::firm) broke.
  bool note_skipped(std::uint32_t group, std::uint64_t count, Nanoseconds late_ns);

  Nanoseconds base_tick_ns() const { return base_tick_ns_; }
  Nanoseconds epoch_ns() const { return epoch_ns_; }
  Nanoseconds time_of(Tick tick) const { return epoch_ns_ + static_cast<Nanoseconds>(tick) * base_tick_ns_; }
  Nanoseconds now() const { return clock_ == nullptr ? 0 : clock_(clock_self_); }
  std::uint32_t group_count() const { return groups_.size(); }
  Group& group(std::uint32_t index) { return groups_[index]; }
  const Group& group(std::uint32_t index) const { return groups_[index]; }
  std::uint32_t task_count() const { return tasks_.size(); }
  TaskBase& task(std::uint32_t index) { return *tasks_[index]; }
  const TaskBase& task(std::uint32_t index) const { return *tasks_[index]; }
  std::uint32_t stream_count() const { return streams_.size(); }
  StreamBase& stream(std::uint32_t index) { return *streams_[index]; }
  const StreamBase& stream(std::uint32_t index) const { return *streams_[index]; }
  Arena& arena() { return arena_; }

  /// Everything that the jobs from `tick` on depend on, except what the tasks keep beside their outputs, to
  /// bytes and back. Every job released before `tick` has run to its end and none behind it; the table is
  /// that of the run that wrote the bytes. Not for the real-time path.
  void archive(Archive& archive, Tick tick);

  /// One number for everything that every task has put out at every tick.
  std::uint64_t digest() const;

 private:
  template <class U, class... Args>
  U* make(const char* pool, Args&&... args) {
    // The arena's memory outlives the run and is dropped whole: destructors have nothing to do.
    const std::span<std::byte> memory = arena_.make_array<std::byte>(pool, sizeof(U), alignof(U));
    return memory.empty() ? nullptr : new (memory.data()) U(std::forward<Args>(args)...);
  }
  std::nullptr_t fail(const char* why) {
    if (error_ == nullptr) error_ = why;
    return nullptr;
  }
  static bool admit(const TaskBase& task, JobContext& context, const JobRecord* recorded);
  static void leave_out(TaskBase& task, JobContext& context);
  JobRecord& open_record(std::uint32_t index, std::uint64_t job, const JobOrder& order);
  void latch(Group& group, JobRecord& record, const JobOrder& order);
  Nanoseconds run_tasks(Group& group, JobRecord& record, const JobOrder& order);
  bool allocate_channels();

  Arena& arena_;
  Nanoseconds base_tick_ns_;
  Nanoseconds epoch_ns_;
  FixedVector<Group, kMaxGroups> groups_;
  FixedVector<TaskBase*, kMaxTasks> tasks_;
  FixedVector<StreamBase*, kMaxStreams> streams_;
  JobSink sink_{};
  Clock clock_{};
  void* clock_self_{};
  void (*guard_)(bool entering){};
  TaskProbe task_probe_{};
  void* task_probe_self_{};
  const char* error_{};
  bool record_fields_{};
  bool digests_{true};
};

/// What the executive's groups and tasks declare, in their order, as the plain table that the analysis works
/// on (rt/schedule.hpp). Before it is sealed all phases are 0.
ScheduleTable declared_table(const Executive& executive);

}  // namespace sortie::rt
