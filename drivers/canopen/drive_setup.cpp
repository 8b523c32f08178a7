// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/drive_setup.hpp"

#include <stdexcept>
#include <string>

namespace sortie::drivers::canopen {
namespace {

std::uint32_t milliseconds(rt::Nanoseconds ns, const char* name) {
  const rt::Nanoseconds ms = ns / rt::kNanosecondsPerMillisecond;
  if (ms < 1 || ms > 65535 || ms * rt::kNanosecondsPerMillisecond != ns)
    throw std::runtime_error(std::string("canopen: ") + name + " must be whole milliseconds, 1 to 65535");
  return static_cast<std::uint32_t>(ms);
}

// An entry of a mapping: object, sub-index 0, bits.
constexpr std::uint32_t entry(std::uint16_t index, std::uint32_t bits) {
  return static_cast<std::uint32_t>(index) << 16u | bits;
}

}  // namespace

DriveSetup::DriveSetup(const DriveConfig& config) {
  if (config.node < 1 || config.node > kMaxNode || config.master < 1 || config.master > kMaxNode ||
      config.node == config.master)
    throw std::runtime_error("canopen: node numbers lie in 1 to 127, and ours is no drive's");
  if (config.heartbeat_timeout_ns <= config.heartbeat_ns)
    throw std::runtime_error(
        "canopen: heartbeat_timeout must be longer than heartbeat; three of it are usual");
  const std::uint32_t heartbeat = milliseconds(config.heartbeat_ns, "heartbeat");
  const std::uint32_t timeout = milliseconds(config.heartbeat_timeout_ns, "heartbeat_timeout");
  const std::uint32_t sync = milliseconds(config.sync_period_ns, "sync period");

  if (config.reading_timeout_ns < 3 * config.sync_period_ns)
    throw std::runtime_error("canopen: readings must be good for three SYNC periods at least");
  if (config.quick_stop_s2 == 0) throw std::runtime_error("canopen: a quick stop needs a deceleration");

  add(SetupKind::expect, 0x1000, 0, kDriveProfile, 4);
  add(SetupKind::write, kQuickStopOption, 0, kQuickStopRamp, 2);
  add(SetupKind::verify, kQuickStopOption, 0, kQuickStopRamp, 2);
  add(SetupKind::write, kQuickStopRate, 0, config.quick_stop_s2, 4);
  add(SetupKind::verify, kQuickStopRate, 0, config.quick_stop_s2, 4);
  add(SetupKind::write, kControlWord, 0, kQuickStop, 2);
  add(SetupKind::settle, kStatusWord, 0, 0, 2);
  const std::uint32_t consumer = static_cast<std::uint32_t>(config.master) << 16u | timeout;
  add(SetupKind::write, 0x1016, 1, consumer, 4);
  add(SetupKind::verify, 0x1016, 1, consumer, 4);
  add(SetupKind::write, kAbortOption, 0, kAbortQuickStop, 2);
  add(SetupKind::verify, kAbortOption, 0, kAbortQuickStop, 2);
  add(SetupKind::write, kModeWanted, 0, static_cast<std::uint32_t>(config.kind), 1);
  if (config.kind == DriveKind::cyclic_position) {
    if (sync > 255) throw std::runtime_error("canopen: the sync period must be at most 255 ms");
    add(SetupKind::write, 0x60C2, 1, sync, 1);
    add(SetupKind::write, 0x60C2, 2, 0xFD, 1);  // 10^-3 s
  }
  const std::uint16_t target = config.kind == DriveKind::velocity ? kTargetVelocity : kTargetPosition;
  const std::uint32_t to_drive[] = {entry(kControlWord, 16), entry(target, 32)};
  const std::uint32_t from_drive[] = {entry(kStatusWord, 16), entry(kPositionActual, 32),
                                      entry(kTorqueActual, 16)};
  map(0x1400, 0x1600, kRpdo1Id + config.node, 0, kPdoAtOnce, to_drive, 2);
  map(0x1800, 0x1A00, kTpdo1Id + config.node, kPdoNoRemote, kPdoEverySync, from_drive, 3);
  // Last, for from now on silence means that the drive is gone.
  add(SetupKind::write, 0x1017, 0, heartbeat, 2);
}

void DriveSetup::add(SetupKind kind, std::uint16_t index, std::uint8_t sub, std::uint32_t value,
                     std::uint8_t bytes) {
  if (!push_back({kind, {index, sub}, value, bytes}))
    throw std::logic_error("canopen: more set-up steps than there is room for");
}

// A mapping may change only while its PDO does not exist and its count is 0 (CiA 301, 7.5.2.36).
void DriveSetup::map(std::uint16_t communication, std::uint16_t mapping, std::uint32_t cob_id,
                     std::uint32_t flags, std::uint8_t transmission, const std::uint32_t* entries,
                     std::uint8_t count) {
  add(SetupKind::write, communication, 1, kPdoOff | flags | cob_id, 4);
  add(SetupKind::write, communication, 2, transmission, 1);
  add(SetupKind::write, mapping, 0, 0, 1);
  for (std::uint8_t i = 0; i < count; ++i)
    add(SetupKind::write, mapping, static_cast<std::uint8_t>(i + 1), entries[i], 4);
  add(SetupKind::write, mapping, 0, count, 1);
  add(SetupKind::write, communication, 1, flags | cob_id, 4);
}

}  // namespace sortie::drivers::canopen
