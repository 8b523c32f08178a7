// SPDX-License-Identifier: BSD-3-Clause
// What a vehicle is built with: written once, it runs live, simulated and over a log.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/can_load.hpp"
#include "firmware_like/runtime/chain_declarations.hpp"
#include "firmware_like/runtime/factories.hpp"
#include "firmware_like/runtime/input_port.hpp"
#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/runtime/parameters.hpp"
#include "firmware_like/runtime/report_queue.hpp"
#include "firmware_like/scene/profile.hpp"
#include "rt/archive.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// Pose of the body at the start of a run, from the profile or from a log's header.
struct InitialPose {
  double p_world_body_m[3]{};
  double q_world_body[4]{1, 0, 0, 0};
};

/// Fill level of a pool that a vehicle reports.
struct PoolLevel {
  std::uint64_t capacity{};
  std::uint64_t high_water{};
  std::uint64_t refused{};
};

/// What a task is declared to be where the profile says nothing else.
struct TaskDefaults {
  double budget_us{};
  rt::Criticality criticality{rt::Criticality::a};
  std::uint32_t units{};  ///< of an anytime task (rt::JobContext::spend), 0: it is none
  /// The scene may say units = "auto": the vehicle can time a unit of this task (Vehicle::try_units).
  bool auto_units{};
};

/// What a vehicle is built with. Everything it hands out lives as long as the runtime. Set-up only; throws
/// ProfileError.
class VehicleBuilder {
 public:
  VehicleBuilder(Profile& profile, rt::Executive& executive, const InitialPose& initial,
                 std::span<const KeptMap> maps = {})
      : profile_(profile), executive_(executive), initial_(initial), kept_maps_(maps) {}

  Profile& profile() { return profile_; }
  rt::Arena& arena() { return executive_.arena(); }
  const InitialPose& initial_pose() const { return initial_; }
  /// The map that the run begins with, if it is one for `table` (KeptMap::table), or null; it lives while the
  /// vehicle is made. Whoever gets it uses it.
  const KeptMap* kept_map(const std::string& table);
  /// A map that was given, and that nothing in the scene asked for; null: there is none.
  const KeptMap* unused_kept_map() const;

  /// A group at the rate of [groups.NAME] rate_hz. Rates that are no whole number of base ticks are errors
  /// that name the nearest legal ones. A group that is there already is given again, at its own rate.
  rt::GroupId group(const std::string& name, double default_rate_hz);

  /// Between two releases of a group.
  rt::Nanoseconds period_ns(rt::GroupId group) const {
    return executive_.group(group.index).timing.period * executive_.base_tick_ns();
  }

  /// True unless [tasks.NAME] enabled = false: what a scene does not need is not built at all.
  bool wants(const std::string& task, bool fallback = true);
  /// Tasks that were asked for and are not wanted, in the order of asking, each once.
  const std::vector<std::string>& left_out() const { return left_out_; }

  /// A task with budget_us, criticality and units of [tasks.NAME]. `function(rt::JobContext&, T& output)`.
  template <rt::Described T, class F>
  rt::Task<T>* task(rt::GroupId group, const std::string& name, const TaskDefaults& defaults, F function) {
    return executive_.add_task<T>(group, task_spec(name, defaults), std::move(function));
  }
  /// The same for a task of criticality A that is no anytime task.
  template <rt::Described T, class F>
  rt::Task<T>* task(rt::GroupId group, const std::string& name, double default_budget_us, F function) {
    return task<T>(group, name, TaskDefaults{default_budget_us}, std::move(function));
  }

  /// Says what `task` keeps from one job to the next beside its output: objects that archive themselves
  /// (rt/archive.hpp) or list their fields, numbers, arrays. They live as long as the vehicle. Without
  /// objects: nothing. A task that says neither runs and replays, but `index` refuses its log.
  template <rt::Archivable... State>
  void remembers(const rt::TaskBase* task, State&... state) {
    memories_.emplace_back(task, [&state...](rt::Archive& archive) { (archive.value(state), ...); });
  }
  /// Archives what `task` remembers. False: it has not said what that is.
  bool archive_memory(const rt::TaskBase& task, rt::Archive& archive) const;

  /// The outputs of `task`, for tasks of another group, with logical execution time. One input a group and
  /// task: whoever asks first says how many jobs it looks back.
  template <rt::Described T>
  rt::Input<T>* input(rt::GroupId reader, const rt::Task<T>* task, std::uint32_t history = 4) {
    if (task == nullptr) return nullptr;
    const std::string name = std::string(task->name()) + "_in_" + group_name(reader);
    if (rt::Input<T>* known = find_named<rt::Input<T>>(name); known != nullptr) return known;
    rt::Input<T>* input = executive_.add_input<T>(reader, task, history);
    if (input == nullptr) return nullptr;
    apply_stale_rule(*input, name);
    put_named(name, input);
    return input;
  }

  /// A stream of samples or of requests from outside; `channel` is its name in the log. A stream that is
  /// there already is given again: all its readers are of one group.
  template <rt::Described T>
  std::pair<rt::Stream<T>*, InputPort<T>*> stream(rt::GroupId reader, const std::string& channel,
                                                  std::uint32_t capacity, std::uint32_t batch) {
    if (auto* known = find_named<rt::Stream<T>>(channel); known != nullptr)
      return {known, find_named<InputPort<T>>(channel)};
    auto* stream = executive_.add_stream<T>(reader, keep(channel), capacity, batch);
    check();
    auto port = std::make_unique<InputPort<T>>(channel, *stream);
    InputPort<T>* handle = port.get();
    ports_.push_back(std::move(port));
    apply_stale_rule(*stream, channel);
    put_named(channel, stream);
    put_named(channel, handle);
    return {stream, handle};
  }
  /// Where samples of `channel` come in, or null where nothing in the scene reads them.
  template <rt::Described T>
  InputPort<T>* find_port(const std::string& channel) const {
    return find_named<InputPort<T>>(channel);
  }

  /// Hands an object of one part to those that are made behind it; it lives as long as the vehicle.
  template <class T>
  void offer(T& object) {
    put_named("", &object);
  }
  /// What was offered as a T, or null.
  template <class T>
  T* find() const {
    return find_named<T>("");
  }

  /// Lets the number at `path`, which profile().number() has read, be changed while the group runs: between
  /// two jobs, in the range of the profile, recorded with the job. `set` runs on the group's thread and must
  /// be real-time safe; it may refuse a value. Declare a group's first parameter before its first task. With
  /// [tasks.parameters] enabled = false nothing can be changed, and no task is there for it.
  void parameter(rt::GroupId group, const std::string& path, ParameterSetter set);
  /// The same for a number that has not been read yet: reads it into `target`, which outlives the runtime's
  /// jobs, and gives it back.
  double parameter(rt::GroupId group, const std::string& path, const NumberSpec& spec, double* target);

  /// A stream of scans with `buffers` pooled buffers of `points` points.
  std::pair<ScanStream*, ScanPort*> scans(rt::GroupId reader, const std::string& channel,
                                          std::uint32_t buffers, std::uint32_t points);

  /// A way out for commands of a group. Counters NAME_late and, where one can be a stop, NAME_late_stops.
  template <class T>
  rt::CommandOutlet<T>* outlet(rt::GroupId group, const std::string& name) {
    rt::CommandOutlet<T>* outlet = executive_.add_outlet<T>(group);
    check();
    counter(name + "_late", [outlet] { return outlet->late(); });
    if constexpr (requires(const T& value) { stops(value); })
      counter(name + "_late_stops", [outlet] { return outlet->late_stops(); });
    return outlet;
  }
  /// A way out for reports, which move nothing.
  template <class T>
  std::unique_ptr<ReportQueue<T>> reports(const std::string& name, std::uint32_t capacity) {
    auto queue = std::make_unique<ReportQueue<T>>(capacity);
    counter(name + "_overrun", [handle = queue.get()] { return handle->overrun(); });
    return queue;
  }

  /// Adds a pool or a counter to every result and to telemetry. The functions are called when no job runs.
  void pool(const std::string& name, std::function<PoolLevel()> level) {
    pools_.emplace_back(name, std::move(level));
  }
  void counter(const std::string& name, std::function<std::uint64_t()> value) {
    counters_.emplace_back(name, std::move(value));
  }
  /// A counter for each field of `counts`, which lives as long as the vehicle: PREFIX and the field's name.
  template <rt::Described T>
  void counters(const std::string& prefix, const T& counts) {
    T::fields(counts, [&](const char* name, const auto& count) {
      counter(prefix + name, [&count] { return std::uint64_t{count}; });
    });
  }

  /// How many samples of `channel` a task has made use of: a run in which samples came and this stayed 0 has
  /// the wrong scene or a wrong sensor, and ends with 1 (stream_use.hpp). Of several for one channel any will
  /// do; without one it is enough that jobs took them. Every vehicle says it of every sensor. Called when no
  /// job runs.
  void uses(const std::string& channel, std::function<std::uint64_t()> used) {
    uses_.emplace_back(channel, std::move(used));
  }

  /// Declares a chain of this vehicle: shown and measured in every run, and bounded where [chains.NAME] says
  /// so. All of its tasks must exist in the scene.
  void chain(const ChainSpec& spec) { chains_.push_back(spec); }

  /// Frames that the vehicle or its devices put on the CAN bus again and again, for the check of its load.
  void bus_frames(std::vector<drivers::CanStream> frames) {
    for (drivers::CanStream& frame : frames) bus_frames_.push_back(std::move(frame));
  }
  const std::vector<drivers::CanStream>& bus_frames() const { return bus_frames_; }

  /// Throws ProfileError if the executive refused something.
  void check() const;

  const ParameterSet& parameters() const { return parameters_; }

  using Pools = std::vector<std::pair<std::string, std::function<PoolLevel()>>>;
  using Counters = std::vector<std::pair<std::string, std::function<std::uint64_t()>>>;
  const std::vector<std::unique_ptr<InputPortBase>>& ports() const { return ports_; }
  const std::vector<ChainSpec>& chains() const { return chains_; }
  /// Tasks whose units the scene leaves to the boot of a live run; until then they have their default.
  const std::vector<std::string>& auto_units() const { return auto_units_; }
  const Pools& pools() const { return pools_; }
  const Counters& counters() const { return counters_; }
  const Counters& uses() const { return uses_; }

 private:
  const char* keep(const std::string& name);
  const char* group_name(rt::GroupId group) const { return executive_.group(group.index).spec.name; }
  rt::TaskSpec task_spec(const std::string& name, const TaskDefaults& defaults);
  // [stale] NAME_ms and NAME_hide; a rule that is on brings a counter stale_NAME.
  rt::StaleRule stale_rule(const std::string& name);
  template <class Port>
  void apply_stale_rule(Port& port, const std::string& name) {
    const rt::StaleRule rule = stale_rule(name);
    port.set_stale_rule(rule);
    if (rule.after_ticks != 0) counter("stale_" + name, [&port] { return port.stale_jobs(); });
  }
  ParameterGroup& parameter_group(rt::GroupId group, const std::string& path);
  template <class T>
  void put_named(std::string_view name, T* thing) {
    offers_.push_back({&kKey<T>, std::string(name), thing});
  }
  // The first that was put there as a T of that name, or null.
  template <class T>
  T* find_named(std::string_view name) const {
    for (const Offer& offer : offers_) {
      if (offer.type == &kKey<T> && offer.name == name) return static_cast<T*>(offer.object);
    }
    return nullptr;
  }

  // Its address stands for the type: a type's own name would tie code to what another build may lack.
  template <class T>
  static inline char kKey{};
  // What the parts of a vehicle hand each other while it is built; it belongs to whoever put it there.
  struct Offer {
    const char* type;
    std::string name;
    void* object;
  };

  Profile& profile_;
  rt::Executive& executive_;
  InitialPose initial_;
  std::span<const KeptMap> kept_maps_;
  std::vector<std::string> maps_asked_;  ///< tables
  std::vector<std::unique_ptr<std::string>> names_;
  std::vector<std::unique_ptr<InputPortBase>> ports_;
  std::vector<ChainSpec> chains_;
  std::vector<drivers::CanStream> bus_frames_;
  std::vector<std::string> auto_units_;
  std::vector<std::string> left_out_;
  std::vector<std::pair<const rt::TaskBase*, std::function<void(rt::Archive&)>>> memories_;
  Pools pools_;
  Counters counters_;
  Counters uses_;
  ParameterSet parameters_;
  std::vector<Offer> offers_;
};

}  // namespace sortie::firmware
