// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iostream>
#include <memory>
#include <sstream>

#include "drivers/wire_records.hpp"
#include "firmware_like/log/releases.hpp"
#include "firmware_like/log/replay_command.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/profile.hpp"
#include "rt/posix/flight_reader.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/export_maps.hpp"
#include "toolchain/export/candump.hpp"
#include "toolchain/export/chrome_trace.hpp"
#include "toolchain/export/csv.hpp"
#include "toolchain/export/flight_jobs.hpp"
#include "toolchain/export/flight_map.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/export/truth_csv.hpp"
#include "toolchain/export/tum.hpp"
#include "toolchain/report/release_plots.hpp"

namespace sortie::toolchain {

namespace {

using firmware::InputError;
using firmware::LogFile;

struct ExportOptions : firmware::ReplayCommand {
  std::string kind;
  std::string path;
  std::string task;
  std::string for_scene;
  std::size_t last{20};
};

void export_tum(const CommandContext& context, const ExportOptions& options, const LogFile& log,
                std::ostream& out) {
  if (options.task == "truth") {
    write_tum(out, log.truth());
    return;
  }
  const firmware::ReplayOutcome outcome = firmware::replay(log, context.parts.vehicles, options.replay);
  const bool on_map = options.task == "locate";
  if (on_map && outcome.located.empty())
    throw InputError(options.log + ": this scene has no task locate; choose one that has, or --task odometry",
                     2);
  // A scene without odometry has no other path.
  write_tum(out, on_map || outcome.estimate.empty() ? outcome.located : outcome.estimate);
}

// A scene for another robot, with what this one came to know of its flight map.
void export_flight_map(const CommandContext& context, ExportOptions& options, const LogFile& log,
                       std::ostream& out) {
  if (options.for_scene.empty()) {
    throw InputError("flight_map needs --for SCENE: the scene of the multirotor that is to fly by the map",
                     2);
  }
  firmware::Profile profile = firmware::load_scene(options.for_scene);
  if (!profile.has("flight_map"))
    throw InputError(options.for_scene + ": has no [flight_map]; choose a scene that plans its ways", 2);
  FlightMapGatherer gatherer(firmware::read_flight_voxels(profile));
  bool has_map = false;
  const auto take = [&](const firmware::Runtime& runtime) {
    const std::optional<mapping::OccupancyView> view = runtime.vehicle().occupancy();
    if (!view) return;
    has_map = true;
    gatherer.take(*view);
  };
  constexpr rt::Tick kEvery = 1000;  // ticks of 1 ms: no window moves on by much in that time
  options.replay.on_tick = [&take](rt::Tick tick, firmware::Runtime& runtime, firmware::LogFeed&) {
    if (tick % kEvery == 0) take(runtime);
  };
  const firmware::ReplayOutcome outcome = firmware::replay(log, context.parts.vehicles, options.replay);
  take(*outcome.runtime);
  if (!has_map) {
    throw InputError(options.log +
                         ": this scene keeps no occupancy map; record one with [tasks.occupancy] and "
                         "[tasks.ssl], as ugv_rescue has them",
                     2);
  }
  const std::size_t free = gatherer.count(firmware::CellState::free);
  if (free == 0) {
    throw InputError(options.log + ": the robot saw nothing of the flight map of " + options.for_scene +
                         "; does flight_map.x_m begin where it drove?",
                     2);
  }
  const std::string from = options.log + " (" + log.header().scene + ", digest " + outcome.results.digest +
                           "): " + std::to_string(free) + " voxels are free, " +
                           std::to_string(gatherer.count(firmware::CellState::blocked)) + " blocked, " +
                           std::to_string(gatherer.count(firmware::CellState::unknown)) + " unknown";
  write_flight_map(out, options.for_scene, profile.name(), from, gatherer.cells());
  std::cerr << "flight map of " << from << "\n";
}

// One row a job of the chosen task, all its fields.
void export_csv(const CommandContext& context, ExportOptions& options, const LogFile& log,
                std::ostream& out) {
  if (options.task == "truth_contacts") return write_contacts_csv(out, log);
  if (options.task == "truth_flippers") return write_flippers_csv(out, log);
  if (options.task == "truth_sensors") return write_sensor_truth_csv(out, log);
  std::unique_ptr<CsvWriter> writer;
  bool known = false;
  std::string names;
  options.replay.on_job = [&](const rt::JobRecord& record, firmware::Runtime& runtime) {
    const rt::Group& group = runtime.executive().group(record.group);
    std::uint32_t offset = 0;
    for (const rt::TaskBase* task : group.tasks) {
      if (task->name() == options.task && offset + task->output_bytes() <= record.field_bytes) {
        known = true;
        struct Row {
          std::vector<std::string> columns;
          std::vector<double> values;
        } row;
        task->describe(
            record.fields + offset,
            {&row, [](void* self, const char* name, int index, double value, std::uint64_t, std::uint32_t) {
               auto* both = static_cast<Row*>(self);
               both->columns.push_back(index < 0 ? std::string(name)
                                                 : std::string(name) + "_" + std::to_string(index));
               both->values.push_back(value);
             }});
        if (!writer) writer = std::make_unique<CsvWriter>(out, row.columns);
        writer->row(runtime.executive().time_of(record.tick), row.values);
      }
      offset += task->output_bytes();
    }
  };
  const firmware::ReplayOutcome outcome = firmware::replay(log, context.parts.vehicles, options.replay);
  if (known) return;
  for (const firmware::TaskResult& task : outcome.results.tasks)
    names += (names.empty() ? "" : ", ") + task.name;
  throw InputError("--task " + options.task + ": no such task; this scene has " + names, 2);
}

void export_candump(const LogFile& log, std::ostream& out) {
  std::vector<drivers::CanFrame> frames;
  for (const firmware::StoredEvent& event : log.channel(std::string(drivers::kChannelCan))) {
    drivers::CanFrame frame;
    if (drivers::decode(event.message, frame) != Status::ok) continue;
    frame.stamp_ns =
        static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(frame.stamp_ns) +
                                     static_cast<std::uint64_t>(log.header().utc_minus_monotonic_ns));
    frames.push_back(frame);
  }
  if (frames.empty())
    throw InputError(log.path() + ": holds no CAN frames; record a run of a vehicle that uses CAN", 2);
  write_candump(out, frames);
}

/// Within 146 years of 0, so that sums with what a job took do not overflow. A log may hold anything.
bool is_near(rt::Nanoseconds time) { return time > -(std::int64_t{1} << 62) && time < std::int64_t{1} << 62; }

void export_trace(const LogFile& log, std::ostream& out) {
  Trace trace;
  std::vector<std::vector<std::string>> tasks;
  std::istringstream groups(log.header().groups);
  for (std::string line; std::getline(groups, line);) {
    std::istringstream words(line);
    std::string name;
    std::string skip;
    words >> name >> skip >> skip >> skip;
    trace.tracks.push_back({static_cast<int>(tasks.size()), name});
    tasks.emplace_back();
    for (std::string task; words >> task;) tasks.back().push_back(task);
  }
  for (const firmware::StoredEvent& event : log.channel(std::string(drivers::kChannelTiming))) {
    drivers::JobTimingRecord timing;
    if (!firmware::read_timing(event, timing) || !is_near(timing.started_ns)) continue;
    const auto group = static_cast<std::size_t>(timing.group);
    if (group >= tasks.size()) continue;
    std::int64_t at = timing.started_ns;
    for (std::size_t i = 0; i < timing.duration_ns.size() && i < tasks[group].size(); ++i) {
      trace.spans.push_back({tasks[group][i],
                             timing.group,
                             at,
                             timing.duration_ns[i],
                             {{"tick", std::to_string(timing.tick)}}});
      at += timing.duration_ns[i];
    }
  }
  if (trace.spans.empty())
    throw InputError(log.path() + ": holds no measured times; record a run with `sortie run --record`", 2);
  std::sort(trace.spans.begin(), trace.spans.end(),
            [](const TraceSpan& a, const TraceSpan& b) { return a.start_ns < b.start_ns; });
  write_chrome_trace(out, trace, trace.spans.front().start_ns);
}

void write_trace(Trace trace, const std::string& path, std::ostream& out) {
  if (trace.spans.empty()) throw InputError(path + ": holds no job", 2);
  std::int64_t first = trace.spans.front().start_ns;
  for (const TraceMark& mark : trace.marks) first = std::min(first, mark.time_ns);
  write_chrome_trace(out, trace, first);
}

int export_ring(const ExportOptions& options) {
  try {
    const rt::posix::FlightReader ring(options.log);
    write_file(options.path, [&](std::ostream& out) {
      if (options.kind == "trace") write_trace(to_trace(ring), options.log, out);
      if (options.kind == "jobs") print_last_jobs(out, ring, options.last);
      if (options.kind == "latency") {
        const std::vector<firmware::GroupResult> groups = firmware::releases_of(ring);
        if (!has_releases(groups)) throw InputError(options.log + ": holds no job", 2);
        out << render_latency_file(groups, std::string(ring.header().scene) + ", last " +
                                               std::to_string(ring.jobs().size()) + " jobs of " +
                                               options.log);
      }
    });
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw InputError(error.what());
  }
  return 0;
}

int run(const CommandContext& context, ExportOptions& options) {
  const bool for_ring = options.kind == "jobs" || options.kind == "trace" || options.kind == "latency";
  const bool is_ring = rt::posix::FlightReader::is_ring(options.log);
  if (options.kind == "jobs" || (for_ring && is_ring)) return export_ring(options);
  if (is_ring)
    throw InputError(options.log + ": is a flight ring, and holds no samples; export jobs, trace or latency",
                     2);
  const LogFile log(options.log);
  const auto replayed = [&] { return firmware::replay(log, context.parts.vehicles, options.replay); };
  write_file(options.path, [&](std::ostream& out) {
    if (options.kind == "tum") export_tum(context, options, log, out);
    if (options.kind == "ply") export_ply(replayed(), log.path(), out);
    if (options.kind == "surfels") export_surfels(replayed(), log.path(), out);
    if (options.kind == "targets") export_targets(replayed(), log.path(), out);
    if (options.kind == "images") export_images(replayed(), log.path(), out);
    if (options.kind == "cloud") export_cloud(replayed(), log.path(), out);
    if (options.kind == "flight_map") export_flight_map(context, options, log, out);
    if (options.kind == "csv") export_csv(context, options, log, out);
    if (options.kind == "candump") export_candump(log, out);
    if (options.kind == "trace") export_trace(log, out);
    if (options.kind == "latency")
      out << render_latency_file(firmware::releases_of(log), log.header().scene + ", " + options.log);
  });
  return firmware::code_with_damage(context.parts.name, log.damage(), options.accept_damage, 0);
}

}  // namespace

void add_export(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<ExportOptions>();
  options->task = "odometry";
  options->path = "-";
  firmware::Command* command =
      app.add_subcommand("export", "Write what a log holds in a form that other tools open");
  command->footer(
      "Kinds: tum (evo), ply (MeshLab, CloudCompare), csv (PlotJuggler, pandas), candump (can-utils), trace "
      "(ui.perfetto.dev), latency (SVG), jobs (text),\n"
      "surfels (the map of surfaces of part locate, for `run --map`),\n"
      "targets (the segments of part recognise, for `run --targets`),\n"
      "images (the height images of part recognise_images, for `run --images`),\n"
      "cloud (what part cloud saw, for `run --map` of another robot),\n"
      "flight_map (a scene with the map that the robot made, for a multirotor)\n"
      "trace, latency and jobs also read the flight ring of a run that died.\n"
      "Examples:\n"
      "  sortie export tum hall.lcm -o hall.tum\n"
      "  sortie export tum walk.lcm --scene lidar_walk --task locate -o walk.tum\n"
      "  sortie export csv hall.lcm --task attitude -o attitude.csv\n"
      "  sortie export csv pallet.lcm --task truth_contacts -o contacts.csv\n"
      "  sortie export surfels ugv.lcm -o hall.surfels\n"
      "  sortie export targets ugv.lcm -o hall.targets\n"
      "  sortie export cloud ugv.lcm -o hall.cloud\n"
      "  sortie export flight_map ugv.lcm --for uav_rescue -o uav.toml\n"
      "  sortie export trace hall.lcm -o hall.trace.json\n"
      "  sortie export latency hall.lcm -o latency.svg\n"
      "  sortie export jobs /dev/shm/sortie-ugv_hall-4711.ring --last 5");
  command->add_option("kind", options->kind, "What to write")
      ->required()
      ->one_of({"tum", "ply", "csv", "candump", "trace", "latency", "jobs", "surfels", "targets", "images",
                "cloud", "flight_map"});
  command->add_option("log", options->log, "LCM log, or a flight ring")->required();
  command->add_option("--last", options->last, "jobs: how many of each group")->capture_default_str();
  command->add_option("-o,--output", options->path, "File; - is standard output")
      ->type_name("FILE")
      ->capture_default_str();
  command
      ->add_option("--task", options->task,
                   "csv: whose output, or truth_contacts, truth_flippers, truth_sensors; tum: `truth` writes "
                   "the reference, `locate` the path on the robot's own map")
      ->capture_default_str();
  command->add_option("--for", options->for_scene, "flight_map: the scene that is to fly by it")
      ->type_name("SCENE");
  add_damage_option(*command, options->accept_damage);
  command->add_option("--scene", options->replay.scene, "Scene for imported logs");
  add_map_options(*command, options->replay.maps);
  command->add_option("--set", options->replay.overrides, "Override a key of the profile: key=value")
      ->take_all();
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
