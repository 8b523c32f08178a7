// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/live_session.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "firmware_like/log/log_clock.hpp"
#include "firmware_like/log/log_event.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/runtime/heap_watch.hpp"
#include "firmware_like/runtime/kept_map.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/fast_clock.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/posix/start_lead.hpp"

namespace sortie::firmware {

namespace {

std::string what_is_outside(const LiveRunOptions& options) {
  const std::string bus = options.can_interface.empty() ? "" : ", CAN on " + options.can_interface;
  return options.plant.empty() ? "live devices" : "a plant in a process of its own" + bus;
}

BootedRuntime boot(const VehicleRegistry& vehicles, const LiveRunOptions& options) {
  const std::vector<KeptMap> maps = read_kept_maps(options.maps);
  return boot_runtime(vehicles, options.scene, overrides_of(maps, options.overrides), !options.virtual_time,
                      maps);
}

bool takes_channel(const Runtime& runtime, std::string_view channel) {
  const auto& ports = runtime.parts().ports();
  return std::any_of(ports.begin(), ports.end(),
                     [channel](const auto& port) { return port->channel() == channel; });
}

}  // namespace

LiveSession::LiveSession(const VehicleRegistry& vehicles, const SimulatorFactory& simulator,
                         const LiveRunOptions& options)
    : options_(options),
      booted_(boot(vehicles, options)),
      runtime_(*booted_.runtime),
      executive_(runtime_.executive()) {
  outcome_.runtime = std::move(booted_.runtime);
  make_simulated(simulator);
  settle_machine();
  open_inputs();
  open_log();
  connect_devices();
  attach();
  open_telemetry();
}

void LiveSession::make_simulated(const SimulatorFactory& simulator) {
  Profile for_robot = load_scene(options_.scene, options_.overrides);
  const bool is_outside = !options_.can_interface.empty() || !options_.plant.empty();
  if (is_outside && options_.virtual_time)
    throw ProfileError("--virtual has its plant inside; leave out --plant and --can");
  if (simulator && !is_outside) robot_ = simulator(for_robot, runtime_.vehicle().scan_sink());
  if (!robot_) return;
  for_robot.refuse_unknown_keys("hil");  // without a simulated robot nobody has declared what [hil] may hold
  outcome_.robot = robot_->describe();
}

void LiveSession::settle_machine() {
  rt::posix::start_fast_clock();
  // Locked now, because locking takes long; the workers ask again and tell what was refused.
  locks_ = !options_.virtual_time && options_.realtime;
  if (locks_) {
    static_cast<void>(rt::posix::lock_memory());
    static_cast<void>(rt::posix::bound_thread_stacks(rt::posix::kThreadStackBytes));
  }
  ring_.emplace(runtime_, options_.flight_ring, options_.virtual_time);
}

void LiveSession::open_inputs() {
  collector_.emplace(runtime_);
  chains_.emplace(runtime_, !options_.virtual_time);
  parameters_.emplace(runtime_);
  // A kernel that has just booted may take seconds for its first random number.
  if (options_.virtual_time) return;
  if (const std::string note = parameters_->open(options_.lcm_url); !note.empty()) warnings_.push_back(note);
}

// Everything that takes long is done: the run begins.
void LiveSession::open_log() {
  start_ns_ = rt::posix::monotonic_now() + (options_.virtual_time ? 0 : start_lead(runtime_, locks_));
  utc_minus_run_ = rt::posix::utc_minus_monotonic() + start_ns_;
  ring_->set_clock(start_ns_, utc_minus_run_ - start_ns_);
  RecorderOptions recording;
  recording.path = options_.record;
  recording.write_fields = options_.record_fields;
  // The draining thread takes the places of ring and log with the first job: whatever is refused before it
  // leaves the files of the run before as they were.
  recording.on_job = [this](const rt::JobRecord& record) {
    ring_->first_job();
    collector_->job(record);
    chains_->job(record);
  };
  recorder_.emplace(
      runtime_, recording,
      make_header(runtime_, robot_ ? robot_->describe() : what_is_outside(options_), utc_minus_log()));
  if (options_.record.empty()) return;
  for (const auto& port : runtime_.parts().ports()) port->set_sink(&*recorder_);
}

void LiveSession::connect_devices() {
  devices_.log = options_.record.empty() ? nullptr : &*recorder_;
  if (robot_) {
    devices_.can = robot_->vehicle_can();
    devices_.ssl = robot_->vehicle_ssl();
    return;
  }
  try {
    runtime_.vehicle().open_devices();
  } catch (const std::runtime_error& error) {
    throw ProfileError(error.what());
  }
  devices_.device_epoch_ns = -start_ns_;
  if (!options_.can_interface.empty()) {
    drivers::SocketCanConfig config;
    config.interface = options_.can_interface;
    config.epoch_ns = start_ns_;
    std::string problem;
    if (can_.open(config, problem) != Status::ok)
      throw ProfileError("--can " + options_.can_interface + ": " + problem);
    devices_.can = &can_;
  }
  if (options_.plant.empty()) return;
  const PlantLinkNeeds needs{devices_.can == nullptr, runtime_.vehicle().scan_sink(),
                             takes_channel(runtime_, drivers::kChannelSsl)};
  link_ = std::make_unique<PlantLink>(parse_plant(options_.plant), needs, start_ns_);
  if (devices_.can == nullptr) devices_.can = link_->can();
  devices_.ssl = link_->ssl();
}

void LiveSession::attach() {
  if (!options_.virtual_time) write_log_clock(*recorder_, start_ns_, utc_minus_run_);
  write_chosen_units(*recorder_, booted_.chosen, booted_.trial.ns_per_unit, utc_minus_log());
  surroundings_.emplace(robot_.get(), devices_, link_.get(), *recorder_);
  executive_.set_sink(ring_->before(recorder_->job_sink()));
  doctor_.begin(executive_, *recorder_, !options_.virtual_time && options_.realtime, utc_minus_log());
  executive_.set_record_fields(true);
  executive_.set_clock(
      [](void* self) { return rt::posix::fast_now() - *static_cast<rt::Nanoseconds*>(self); }, &start_ns_);
  const HeapWatch heap = heap_watch();
  heap_before_ = heap.calls != nullptr ? heap.calls() : 0;
  const auto length = std::llround(options_.seconds * 1e9 / static_cast<double>(executive_.base_tick_ns()));
  last_ = static_cast<rt::Tick>(std::max(length, 1LL) - 1);  // one tick at least
}

void LiveSession::open_telemetry() {
  if constexpr (rt::kBuilt<"telemetry">) {
    if (runtime_.outlets().telemetry)
      telemetry_ =
          std::make_unique<Telemetry>(runtime_, *recorder_, *parameters_, options_.lcm_url, utc_minus_run_);
  }
  if (telemetry_ && !telemetry_->problem().empty()) warnings_.push_back(telemetry_->problem());
  if (!telemetry_ && parameters_->listens())
    warnings_.push_back(
        "requests are taken, but nobody can hear which run this is, and so make one; cure: "
        "live.telemetry=true");
  warnings_.insert(warnings_.end(), ring_->warnings().begin(), ring_->warnings().end());
  if (!doctor_.warning().empty()) warnings_.push_back(doctor_.warning());
  if (const std::string tight = unit_warning(booted_.trial); !tight.empty()) warnings_.push_back(tight);
}

void LiveSession::run() {
  const auto began = std::chrono::steady_clock::now();
  if (options_.virtual_time)
    run_virtually();
  else
    run_live_threads();
  wall_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  ring_->finish(executive_.time_of(ticks_));
  health_ = doctor_.finish(executive_, *recorder_, executive_.time_of(ticks_));
  collect_measured();
  recorder_->stop();
  if (ring_->stays()) outcome_.flight_ring = ring_->path();
  if (!ring_->place_problem().empty()) warnings_.push_back(ring_->place_problem());
  if (recorder_->log_is_there()) outcome_.log = options_.record;
  outcome_.former_log = recorder_->former_log();
}

void LiveSession::run_virtually() {
  if (!robot_)
    throw ProfileError(options_.scene +
                       (*rt::kOnlyScene == '\0'
                            ? ": --virtual needs a scene with a simulated robot ([hil])"
                            : ": this program was built for one scene and has no simulated robot; "
                              "take the program with all scenes, or give --can or --plant"));
  executive_.set_guard(heap_watch().arm);
  SimulatedFeed feed(*surroundings_, runtime_, *recorder_, *parameters_);
  constexpr rt::Tick kChunk = 256;
  for (; ticks_ <= last_; ticks_ += kChunk) {
    if (options_.interrupted != nullptr && options_.interrupted->load()) return;
    rt::run_virtual(executive_, feed, ticks_, std::min(last_, ticks_ + kChunk - 1));
    if (options_.progress) options_.progress(static_cast<double>(ticks_) / static_cast<double>(last_ + 1));
  }
  ticks_ = last_ + 1;
}

void LiveSession::run_live_threads() {
  recorder_->start();
  if (telemetry_) telemetry_->start();
  EventDesk desk(runtime_, *recorder_, telemetry_.get(), *ring_, utc_minus_run_);
  if (!ring_->before_this().empty()) desk.tell("run_before", "run", ring_->before_this(), 0);
  live_ = run_in_real_time({runtime_, *surroundings_, *parameters_, *recorder_, desk, *chains_}, options_,
                           start_ns_, last_);
  ticks_ = live_.ticks;
  if (telemetry_) telemetry_->stop();
  if (options_.require_realtime && !live_.warnings.empty()) throw PlatformRefused(live_.warnings.front());
  write_run_end(*recorder_, executive_, ticks_, utc_minus_run_);
  warnings_.insert(warnings_.end(), live_.warnings.begin(), live_.warnings.end());
  if (!live_.late_start.empty()) warnings_.push_back(live_.late_start);
  outcome_.stopped = live_.stopped;
}

LiveRunOutcome run_live(const VehicleRegistry& vehicles, const SimulatorFactory& simulator,
                        const LiveRunOptions& options) {
  LiveSession session(vehicles, simulator, options);
  session.run();
  return session.collect();
}

}  // namespace sortie::firmware
