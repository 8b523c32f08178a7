// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/ugv_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace sortie::drivers::canopen {
namespace {

std::uint32_t rate(double value, double per_unit, const char* name) {
  const double whole = std::floor(value * per_unit + 0.5);
  if (!(whole >= 1.0 && whole <= 4e9))
    throw std::runtime_error(std::string("canopen: ") + name + " in increments must lie in 1 to 4e9");
  return static_cast<std::uint32_t>(whole);
}

std::vector<DriveConfig> drives_of(const UgvNodesConfig& config) {
  if (!(config.increments_per_m >= 1.0 && config.increments_per_m <= 1e8) ||
      !(config.increments_per_rad >= 1.0 && config.increments_per_rad <= 1e8))
    throw std::runtime_error("canopen: increments a metre and a radian lie in 1 to 1e8");
  if (!(config.rated_torque_n_m > 0.0 && config.rated_torque_n_m <= 1e6))
    throw std::runtime_error("canopen: the rated torque must be above 0");
  DriveConfig drive;
  drive.master = config.line.node;
  drive.sync_period_ns = config.line.sync_period_ns;
  drive.heartbeat_ns = config.line.heartbeat_ns;
  drive.heartbeat_timeout_ns = config.heartbeat_timeout_ns;
  std::vector<DriveConfig> drives;
  drive.quick_stop_s2 = rate(config.quick_stop_m_s2, config.increments_per_m, "quick_stop_m_s2");
  // Five cycles without one, and the drive is lost; three where a cycle is long.
  drive.reading_timeout_ns = std::max(3 * config.line.sync_period_ns, 50 * rt::kNanosecondsPerMillisecond);
  for (const std::uint8_t node : config.track_nodes) {
    drive.node = node;
    drives.push_back(drive);
  }
  drive.kind = DriveKind::cyclic_position;
  drive.quick_stop_s2 = rate(config.quick_stop_rad_s2, config.increments_per_rad, "quick_stop_rad_s2");
  for (const std::uint8_t node : config.flipper_nodes) {
    if (!config.flippers) break;
    drive.node = node;
    drives.push_back(drive);
  }
  return drives;
}

// A start is three steps of CiA 402 and a fault's reset, each a command, and a reading a cycle later.
constexpr int kStartCycles = 12;

DriveGroupConfig group_of(const UgvNodesConfig& config) {
  DriveGroupConfig group = config.group;
  group.start_timeout_ns = std::max(group.start_timeout_ns, kStartCycles * config.line.sync_period_ns);
  return group;
}

}  // namespace

std::int64_t IncrementCount::add(std::int32_t reading) noexcept {
  // The difference of unsigned numbers wraps as the counter does.
  const auto moved =
      static_cast<std::int32_t>(static_cast<std::uint32_t>(reading) - static_cast<std::uint32_t>(last_));
  if (begun_) total_ += moved;
  begun_ = true;
  last_ = reading;
  return total_;
}

UgvNodes::UgvNodes(const UgvNodesConfig& config)
    : UgvDrives(group_of(config), config.flippers, config.increments_per_m, config.increments_per_rad),
      config_(config),
      line_(config.line, drives_of(config)) {
  attach_all();
}

UgvNodes::UgvNodes(const UgvNodes& other)
    : UgvDrives(other),
      config_(other.config_),
      line_(other.line_),
      travel_(other.travel_),
      set_ups_(other.set_ups_),
      tracks_ns_(other.tracks_ns_),
      flippers_ns_(other.flippers_ns_) {
  attach_all();
}

void UgvNodes::attach_all() {
  std::array<MotorDrive*, kMaxDrives> drives{};
  for (std::size_t i = 0; i < line_.size(); ++i) drives[i] = &line_.drive(i);
  attach({drives.data(), line_.size()});
}

void UgvNodes::poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  line_.watch(!group().torque(), now_ns);
  std::array<double, kMaxDrives> standing{};
  for (std::size_t i = 0; i < line_.size(); ++i) standing[i] = line_.drive(i).reading().position;
  decide(line_.works(now_ns), {standing.data(), line_.size()}, now_ns);
  line_.send(now_ns, bus);
}

bool UgvNodes::all_read(std::size_t first, std::size_t count) const noexcept {
  for (std::size_t i = first; i < first + count; ++i) {
    const Drive& drive = line_.drive(i);
    if (drive.phase() != DrivePhase::operational || drive.reading().stamp_ns < line_.sync_ns()) return false;
  }
  return true;
}

// A drive that was set up again may count from zero: travel goes on from where it was.
double UgvNodes::travel_m(std::size_t track) noexcept {
  const Drive& drive = line_.drive(track);
  if (set_ups_[track] != drive.counters().set_ups) travel_[track].rebase();
  set_ups_[track] = drive.counters().set_ups;
  return static_cast<double>(travel_[track].add(drive.reading().position)) / config_.increments_per_m;
}

Status UgvNodes::read(rt::TrackSample& sample) noexcept {
  if (line_.sync_ns() <= tracks_ns_ || !all_read(0, kTracks)) return Status::empty;
  tracks_ns_ = line_.sync_ns();
  sample = {};
  sample.stamp_ns = tracks_ns_;
  sample.left_m = travel_m(0);
  sample.right_m = travel_m(1);
  return Status::ok;
}

Status UgvNodes::read(rt::FlipperSample& sample) noexcept {
  if (!config_.flippers || line_.sync_ns() <= flippers_ns_ || !all_read(kTracks, rt::kFlippers))
    return Status::empty;
  flippers_ns_ = line_.sync_ns();
  sample = {};
  sample.stamp_ns = flippers_ns_;
  for (std::size_t i = 0; i < rt::kFlippers; ++i) {
    const DriveReading& reading = line_.drive(kTracks + i).reading();
    sample.angle_rad[i] = reading.position / config_.increments_per_rad;
    sample.torque_n_m[i] = 1e-3 * reading.torque * config_.rated_torque_n_m;
  }
  return Status::ok;
}

// Set-up, network management and emergencies come rarely and are left out.
std::vector<CanStream> bus_frames(const UgvNodesConfig& config) {
  std::vector<CanStream> frames;
  const auto add = [&](std::string name, std::uint32_t id, std::uint8_t size, rt::Nanoseconds period_ns) {
    frames.push_back({.name = std::move(name), .id = id, .size = size, .period_ns = period_ns});
    return &frames.back();
  };
  const rt::Nanoseconds sync_ns = config.line.sync_period_ns;
  // Ours leave through one interface, SYNC before the commands.
  constexpr int kOurs = 0;
  add("sync", kSyncId, 0, sync_ns)->queue = kOurs;
  add("heartbeat of the runtime", kHeartbeatId + config.line.node, 1, config.line.heartbeat_ns)->queue =
      kOurs;
  const auto drive = [&](std::uint8_t node) {
    const std::string of = " of drive " + std::to_string(node);
    add("command" + of, kRpdo1Id + node, 6, sync_ns)->queue = kOurs;
    add("reading" + of, kTpdo1Id + node, 8, sync_ns)->after = 0;
    add("heartbeat" + of, kHeartbeatId + node, 1, config.line.heartbeat_ns);
  };
  for (const std::uint8_t node : config.track_nodes) drive(node);
  for (const std::uint8_t node : config.flipper_nodes) {
    if (config.flippers) drive(node);
  }
  return frames;
}

}  // namespace sortie::drivers::canopen
