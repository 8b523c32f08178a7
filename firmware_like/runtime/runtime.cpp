// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/runtime.hpp"

#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <new>
#include <sstream>

#include "firmware_like/runtime/kept_map.hpp"
#include "rt/math.hpp"

namespace sortie::firmware {

namespace {

// Address space to build in: pages that nobody touches cost nothing, and what is left over is given back. It
// grows until everything fits, as a 32-bit processor has little of it.
constexpr std::size_t kFirstMemory = std::size_t{32} << 20;
constexpr std::size_t kMostMemory = sizeof(void*) == 8 ? std::size_t{32} << 30 : std::size_t{1} << 30;

std::byte* map_memory(std::size_t bytes) {
  void* memory =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return static_cast<std::byte*>(memory);
}

// Times and threads of the run itself (start, length) are the caller's.
rt::posix::LiveOptions read_live_settings(Profile& profile) {
  rt::posix::LiveOptions live;
  live.stuck_limit_ns = rt::kNanosecondsPerSecond;
  profile.read("live", live);
  if (live.margin.least_ns > live.margin.most_ns)
    profile.fail("live.margin_least_us", "must not be above live.margin_most_us");
  if (live.ladder.return_load >= live.ladder.most_load)
    profile.fail("ladder.return_load", "must be below ladder.most_load, or the ladder would swing");
  return live;
}

}  // namespace

InitialPose read_initial(Profile& profile) {
  InitialPose pose;
  const char* const axes[] = {"initial.x_m", "initial.y_m", "initial.z_m"};
  for (int i = 0; i < 3; ++i)
    pose.p_world_body_m[i] =
        profile.number(axes[i], {0, -1e6, 1e6, "m", "start position in the world, if no log gives one"});
  const double yaw =
      profile.number("initial.yaw_deg", {0, -360, 360, "deg", "start heading, if no log gives one"});
  const rt::SinCos half = rt::sincos(yaw * 3.14159265358979323846 / 360.0);
  pose.q_world_body[0] = half.cos;
  pose.q_world_body[3] = half.sin;
  return pose;
}

Runtime::Runtime(Profile profile, const VehicleRegistry& vehicles, const RuntimeStart& start)
    : profile_(std::move(profile)) {
  for (mapped_bytes_ = kFirstMemory; !fits(vehicles, start); mapped_bytes_ *= 4) {
    if (mapped_bytes_ > kMostMemory / 4) throw std::bad_alloc();
  }
  memory_bytes_ = static_cast<std::size_t>(arena_->needed_bytes());
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t kept = (memory_bytes_ + page - 1) / page * page;
  arena_->end_at(memory_bytes_);
  if (kept < mapped_bytes_ && ::munmap(mapping_ + kept, mapped_bytes_ - kept) == 0) mapped_bytes_ = kept;
}

bool Runtime::fits(const VehicleRegistry& vehicles, const RuntimeStart& start) {
  mapping_ = map_memory(mapped_bytes_);
  try {
    build(vehicles, start);
    if (arena_->refused() == 0) {
      profile_.refuse_unknown_keys("", "hil");  // [hil] is for a test bench, if there is one
      return true;
    }
  } catch (...) {
    // Whatever went wrong may be for want of room; then it is tried again with more.
    if (!arena_ || arena_->refused() == 0) {
      drop();
      throw;
    }
  }
  drop();
  return false;
}

Runtime::~Runtime() { drop(); }

void Runtime::drop() {
  vehicle_.reset();
  builder_.reset();
  executive_.reset();
  arena_.reset();
  if (mapping_ != nullptr) ::munmap(mapping_, mapped_bytes_);
  mapping_ = nullptr;
}

void Runtime::build(const VehicleRegistry& vehicles, const RuntimeStart& start) {
  const auto tick_us = profile_.integer("time.base_tick_us", {1000, 50, 1e6, "us", "length of a tick"});
  const InitialPose said = read_initial(profile_);
  const InitialPose& initial = start.has_initial ? start.initial : said;
  live_settings_ = read_live_settings(profile_);
  outlets_ = {};
  profile_.read("live", outlets_);
  arena_ = std::make_unique<rt::Arena>(std::span<std::byte>(mapping_, mapped_bytes_));
  executive_ =
      std::make_unique<rt::Executive>(*arena_, tick_us * rt::kNanosecondsPerMicrosecond, start.epoch_ns);
  builder_ = std::make_unique<VehicleBuilder>(profile_, *executive_, initial, start.maps);
  const auto factory = std::find_if(vehicles.begin(), vehicles.end(),
                                    [this](const auto& entry) { return entry.first == profile_.vehicle(); });
  if (factory == vehicles.end()) {
    std::string known;
    for (const auto& [name, unused] : vehicles) known += (known.empty() ? "" : ", ") + name;
    profile_.fail("scene.vehicle", "unknown vehicle \"" + profile_.vehicle() + "\"; known: " + known);
  }
  vehicle_ = factory->second(*builder_);
  if (const KeptMap* map = builder_->unused_kept_map(); map != nullptr)
    throw ProfileError(map->option + " " + map->path + ": scene " + profile_.name() +
                       " has no part that uses a " + map->kind() + "; leave out " + map->option +
                       ", or add --set tasks." + map->table + ".enabled=true");
  read_parameter_keys();
  if (executive_->seal() != Status::ok) profile_.fail("scene", executive_->error());
  schedule_ = check_schedule(profile_, *executive_);
  chains_ = read_chains(profile_, *builder_, *executive_, schedule_.warnings);
  bus_ = check_bus(profile_, builder_->bus_frames(), schedule_.warnings);
}

std::vector<PoolResult> Runtime::memory_plan() const {
  std::vector<PoolResult> plan;
  for (const rt::PoolRecord& record : arena_->report()) {
    auto entry = std::find_if(plan.begin(), plan.end(),
                              [&record](const PoolResult& pool) { return pool.name == record.name; });
    if (entry == plan.end()) entry = plan.insert(plan.end(), PoolResult{record.name, 0, 0, 0, 0});
    entry->capacity += record.capacity;
    entry->bytes += record.bytes;
  }
  return plan;
}

std::string Runtime::group_table() const {
  std::string table;
  const auto us = [this](std::uint64_t ticks) {
    return std::to_string(static_cast<std::int64_t>(ticks) * executive_->base_tick_ns() / 1000);
  };
  for (std::uint32_t i = 0; i < executive_->group_count(); ++i) {
    const rt::Group& group = executive_->group(i);
    table += std::string(group.spec.name) + " " + us(group.timing.period) + " " + us(group.timing.phase) +
             " " + us(group.timing.deadline);
    for (const rt::TaskBase* task : group.tasks) table += " " + std::string(task->name());
    table += "\n";
  }
  return table;
}

std::string Runtime::task_table() const {
  std::string table;
  for (std::uint32_t i = 0; i < executive_->task_count(); ++i) {
    const rt::TaskBase& task = executive_->task(i);
    const rt::Group& group = executive_->group(task.group());
    table += std::string(task.name()) + " " + group.spec.name + " " +
             std::to_string(group.timing.period * executive_->base_tick_ns() / 1000) + " " +
             std::to_string(task.budget_us()) + "\n";
  }
  return table;
}

void Runtime::archive(rt::Archive& archive, rt::Tick tick) {
  executive_->archive(archive, tick);
  for (std::uint32_t i = 0; i < executive_->task_count(); ++i) {
    archive.expect(i, "what the tasks remember lies in another order");
    if (!builder_->archive_memory(executive_->task(i), archive))
      archive.fail(Status::not_supported, "a task has not declared what it remembers");
  }
}

std::vector<std::string> Runtime::undeclared_state() const {
  std::vector<std::string> lines;
  for (std::uint32_t i = 0; i < executive_->task_count(); ++i) {
    const rt::TaskBase& task = executive_->task(i);
    const std::string place = "vehicle " + profile_.vehicle() + ", task " + task.name();
    rt::Archive measure = rt::Archive::measuring();
    if (task.hides_state()) {
      lines.push_back(
          place +
          ": its function changes its own captures, which nobody can archive; move them to a member "
          "of the vehicle and name that in VehicleBuilder::remembers()");
    } else if (!builder_->archive_memory(task, measure)) {
      lines.push_back(
          place +
          ": has not declared its state; call VehicleBuilder::remembers(task, object...) with what it "
          "keeps beside its output, or remembers(task) if that is nothing");
    } else if (measure.status() != Status::ok) {
      lines.push_back(place + ": " + measure.where() + ": " + measure.why());
    }
  }
  return lines;
}

void Runtime::read_parameter_keys() {
  access_.remote =
      profile_.flag("parameters.remote", false, "`sortie set` may change parameters of a live run");
  access_.robot = profile_.text("robot.name", "",
                                "what the run calls itself to who commands it; empty: the computer's name");
  access_.secret_file = profile_.text(
      "parameters.secret_file", "", "32 hexadecimal digits; only who knows them may set parameters or drive");
  if (access_.secret_file.empty()) {
    access_.without_secret =
        profile_.flag("parameters.without_secret", false,
                      "on a bench: takes requests from anybody; else there are none without");
  } else {
    access_.most_clock_offset_ns = std::llround(
        1e6 * profile_.number("parameters.max_request_age_ms",
                              {2000, 0, 1e6, "ms", "requests of a clock further away are refused; 0: any"}));
  }
  script_ = profile_.script();
  for (const ScriptLine& line : script_) {
    const std::string path = "script[" + std::to_string(line.row) + "]";
    const ParameterInfo* info = builder_->parameters().find(line.name);
    if (info == nullptr) {
      std::string known;
      for (const ParameterInfo& other : builder_->parameters().all)
        known += (known.empty() ? "" : ", ") + std::string(other.key().name);
      profile_.fail(path, line.name + " is no run-time parameter of this scene; known: " +
                              (known.empty() ? "none" : known));
    }
    if (info->owner->table.check(line.name, line.value) != Status::ok) {
      std::ostringstream why;
      const rt::KeyRange& range = info->key();
      why << line.name << " = " << line.value << " is outside " << range.low << " .. " << range.high << " "
          << range.unit.name;
      profile_.fail(path, why.str());
    }
  }
}

}  // namespace sortie::firmware
