// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/frames.hpp"

#include <algorithm>
#include <initializer_list>

namespace sortie::drivers::canopen {
namespace {

constexpr std::uint8_t kReadCommand = 0x40;
constexpr std::uint8_t kWrittenCommand = 0x60;
constexpr std::uint8_t kAbortCommandByte = 0x80;
constexpr std::uint8_t kWriteCommand = 0x20;  // and the client's data bits; the same bits with 0x40: a value
constexpr std::uint8_t kExpedited = 2;
constexpr std::uint8_t kSizeSaid = 1;

// Whether `raw` is one of the values that have a meaning.
template <class Enum>
bool is_one_of(std::initializer_list<Enum> values, std::uint8_t raw) {
  return std::any_of(values.begin(), values.end(),
                     [raw](Enum value) { return raw == static_cast<std::uint8_t>(value); });
}

// Node of a frame whose identifier is `base` + node; 0: it is another frame.
std::uint8_t node_of(const CanFrame& frame, std::uint32_t base) {
  if (frame.flags != 0 || frame.id <= base || frame.id > base + kMaxNode) return 0;
  return static_cast<std::uint8_t>(frame.id - base);
}

CanFrame frame_of(std::uint32_t id, std::uint8_t size) {
  CanFrame frame;
  frame.id = id;
  frame.size = size;
  return frame;
}

CanFrame encode_sdo(std::uint32_t id, const Sdo& sdo) {
  CanFrame frame = frame_of(id, 8);
  switch (sdo.kind) {
    case SdoKind::read:
      frame.data[0] = kReadCommand;
      break;
    case SdoKind::written:
      frame.data[0] = kWrittenCommand;
      break;
    case SdoKind::abort:
      frame.data[0] = kAbortCommandByte;
      break;
    case SdoKind::write:
    case SdoKind::value: {
      const unsigned base = sdo.kind == SdoKind::write ? kWriteCommand : kReadCommand;
      const unsigned size = sdo.bytes == 0 ? 0u : (4u - sdo.bytes) << 2u | kSizeSaid;
      frame.data[0] = static_cast<std::uint8_t>(base | kExpedited | size);
      break;
    }
  }
  write_le(frame, 1, 2, sdo.key.index);
  frame.data[3] = sdo.key.sub;
  if (sdo.kind != SdoKind::read && sdo.kind != SdoKind::written) write_le(frame, 4, 4, sdo.value);
  return frame;
}

// `transfer` is what a command byte with data bits has in its upper three bits, and what that means.
Status decode_sdo(const CanFrame& frame, SdoKind plain_kind, std::uint8_t plain_command, SdoKind data_kind,
                  std::uint8_t data_command, Sdo& sdo) {
  if (frame.size != 8) return Status::malformed;
  Sdo out;
  out.key = {static_cast<std::uint16_t>(read_le(frame, 1, 2)), frame.data[3]};
  const std::uint8_t command = frame.data[0];
  if (command == kAbortCommandByte) {
    out.kind = SdoKind::abort;
    out.value = read_le(frame, 4, 4);
  } else if (command == plain_command) {
    out.kind = plain_kind;
  } else if ((command & 0xE0u) == data_command && (command & kExpedited) != 0) {
    if ((command & 0x10u) != 0) return Status::malformed;
    const unsigned unused = (command >> 2u) & 3u;
    const bool said = (command & kSizeSaid) != 0;
    if (!said && unused != 0) return Status::malformed;
    out.kind = data_kind;
    out.bytes = said ? static_cast<std::uint8_t>(4u - unused) : std::uint8_t{0};
    out.value = read_le(frame, 4, said ? out.bytes : 4u);
  } else {
    return Status::not_supported;
  }
  sdo = out;
  return Status::ok;
}

}  // namespace

std::uint32_t read_le(const CanFrame& frame, unsigned first, unsigned bytes) noexcept {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < bytes && first + i < sizeof frame.data; ++i)
    value |= static_cast<std::uint32_t>(frame.data[first + i]) << (8u * i);
  return value;
}

void write_le(CanFrame& frame, unsigned first, unsigned bytes, std::uint32_t value) noexcept {
  for (unsigned i = 0; i < bytes && first + i < sizeof frame.data; ++i)
    frame.data[first + i] = static_cast<std::uint8_t>(value >> (8u * i) & 0xFFu);
}

CanFrame encode_nmt(NmtCommand command, std::uint8_t node) noexcept {
  CanFrame frame = frame_of(kNmtId, 2);
  frame.data[0] = static_cast<std::uint8_t>(command);
  frame.data[1] = node;
  return frame;
}

Status decode_nmt(const CanFrame& frame, NmtCommand& command, std::uint8_t& node) noexcept {
  if (frame.flags != 0 || frame.id != kNmtId) return Status::not_supported;
  if (frame.size != 2 || frame.data[1] > kMaxNode ||
      !is_one_of({NmtCommand::start, NmtCommand::stop, NmtCommand::pre_operational, NmtCommand::reset_node,
                  NmtCommand::reset_communication},
                 frame.data[0]))
    return Status::malformed;
  command = static_cast<NmtCommand>(frame.data[0]);
  node = frame.data[1];
  return Status::ok;
}

CanFrame encode_sync() noexcept { return frame_of(kSyncId, 0); }

bool is_sync(const CanFrame& frame) noexcept {
  // With a counter it is one byte long, which is none of our business.
  return frame.flags == 0 && frame.id == kSyncId && frame.size <= 1;
}

CanFrame encode_heartbeat(std::uint8_t node, NmtState state) noexcept {
  CanFrame frame = frame_of(kHeartbeatId + node, 1);
  frame.data[0] = static_cast<std::uint8_t>(state);
  return frame;
}

Status decode_heartbeat(const CanFrame& frame, std::uint8_t& node, NmtState& state) noexcept {
  const std::uint8_t from = node_of(frame, kHeartbeatId);
  if (from == 0) return Status::not_supported;
  if (frame.size != 1 ||
      !is_one_of({NmtState::boot_up, NmtState::stopped, NmtState::operational, NmtState::pre_operational},
                 frame.data[0]))
    return Status::malformed;
  node = from;
  state = static_cast<NmtState>(frame.data[0]);
  return Status::ok;
}

CanFrame encode_emergency(std::uint8_t node, const Emergency& emergency) noexcept {
  CanFrame frame = frame_of(kEmergencyId + node, 8);
  write_le(frame, 0, 2, emergency.code);
  frame.data[2] = emergency.error_register;
  return frame;
}

Status decode_emergency(const CanFrame& frame, std::uint8_t& node, Emergency& emergency) noexcept {
  const std::uint8_t from = node_of(frame, kEmergencyId);
  if (from == 0) return Status::not_supported;
  if (frame.size != 8) return Status::malformed;
  node = from;
  emergency = {static_cast<std::uint16_t>(read_le(frame, 0, 2)), frame.data[2]};
  return Status::ok;
}

CanFrame encode_sdo_request(std::uint8_t node, const Sdo& sdo) noexcept {
  return encode_sdo(kSdoRequestId + node, sdo);
}

CanFrame encode_sdo_reply(std::uint8_t node, const Sdo& sdo) noexcept {
  return encode_sdo(kSdoReplyId + node, sdo);
}

Status decode_sdo_request(const CanFrame& frame, std::uint8_t& node, Sdo& sdo) noexcept {
  const std::uint8_t to = node_of(frame, kSdoRequestId);
  if (to == 0) return Status::not_supported;
  const Status status = decode_sdo(frame, SdoKind::read, kReadCommand, SdoKind::write, kWriteCommand, sdo);
  if (status == Status::ok) node = to;
  return status;
}

Status decode_sdo_reply(const CanFrame& frame, std::uint8_t& node, Sdo& sdo) noexcept {
  const std::uint8_t from = node_of(frame, kSdoReplyId);
  if (from == 0) return Status::not_supported;
  const Status status =
      decode_sdo(frame, SdoKind::written, kWrittenCommand, SdoKind::value, kReadCommand, sdo);
  if (status == Status::ok) node = from;
  return status;
}

}  // namespace sortie::drivers::canopen
