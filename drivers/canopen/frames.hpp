// SPDX-License-Identifier: BSD-3-Clause
// CANopen's messages on the bus (CiA 301): identifiers, network management, heartbeat, SYNC, emergency and
// expedited SDO. Encoders and decoders alone; who sends what when is said elsewhere.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"
#include "rt/status.hpp"

namespace sortie::drivers::canopen {

/// Identifiers of the predefined connection set; a node's number, 1 to 127, is added to those marked (n).
inline constexpr std::uint32_t kNmtId = 0x000;
inline constexpr std::uint32_t kSyncId = 0x080;
inline constexpr std::uint32_t kEmergencyId = 0x080;   ///< (n)
inline constexpr std::uint32_t kTpdo1Id = 0x180;       ///< (n) from the node
inline constexpr std::uint32_t kRpdo1Id = 0x200;       ///< (n) to the node
inline constexpr std::uint32_t kSdoReplyId = 0x580;    ///< (n)
inline constexpr std::uint32_t kSdoRequestId = 0x600;  ///< (n)
inline constexpr std::uint32_t kHeartbeatId = 0x700;   ///< (n)
inline constexpr std::uint8_t kMaxNode = 127;

/// What network management asks of a node.
enum class NmtCommand : std::uint8_t {
  start = 1,
  stop = 2,
  pre_operational = 128,
  reset_node = 129,
  reset_communication = 130,
};

/// What a heartbeat says of its node.
enum class NmtState : std::uint8_t { boot_up = 0, stopped = 4, operational = 5, pre_operational = 127 };

/// An emergency: code 0 takes the one before back.
struct Emergency {
  std::uint16_t code{};
  std::uint8_t error_register{};
};

/// Asks node `node`, or all with 0.
CanFrame encode_nmt(NmtCommand command, std::uint8_t node) noexcept;
/// Status: ok; malformed (size, undefined command, node above 127); not_supported (another identifier).
[[nodiscard]] Status decode_nmt(const CanFrame& frame, NmtCommand& command, std::uint8_t& node) noexcept;

/// SYNC without a counter.
CanFrame encode_sync() noexcept;
bool is_sync(const CanFrame& frame) noexcept;

CanFrame encode_heartbeat(std::uint8_t node, NmtState state) noexcept;
/// Status: ok; malformed (size, undefined state); not_supported (another identifier).
[[nodiscard]] Status decode_heartbeat(const CanFrame& frame, std::uint8_t& node, NmtState& state) noexcept;

CanFrame encode_emergency(std::uint8_t node, const Emergency& emergency) noexcept;
/// Status: ok; malformed (size); not_supported (another identifier).
[[nodiscard]] Status decode_emergency(const CanFrame& frame, std::uint8_t& node,
                                      Emergency& emergency) noexcept;

/// One entry of an object dictionary.
struct ObjectKey {
  std::uint16_t index{};
  std::uint8_t sub{};
  constexpr bool operator==(const ObjectKey&) const = default;
};

/// Why a node refused an SDO (CiA 301, table 22); the codes that this code sends.
inline constexpr std::uint32_t kAbortTimeout = 0x0504'0000;
inline constexpr std::uint32_t kAbortReadOnly = 0x0601'0002;
inline constexpr std::uint32_t kAbortNoObject = 0x0602'0000;
inline constexpr std::uint32_t kAbortNotMappable = 0x0604'0041;
inline constexpr std::uint32_t kAbortSize = 0x0607'0010;
inline constexpr std::uint32_t kAbortValue = 0x0609'0030;
inline constexpr std::uint32_t kAbortState = 0x0800'0022;

/// What an SDO frame says.
enum class SdoKind : std::uint8_t { read, write, value, written, abort };

/// An expedited SDO, either way. `value` holds `bytes` bytes, little endian; of an abort, its code.
struct Sdo {
  SdoKind kind{};
  ObjectKey key{};
  std::uint32_t value{};
  std::uint8_t bytes{};  ///< 1 to 4 of write and value; 0: the sender did not say, take what the object has
};

/// A client's frame (read, write, abort) to `node`, or a server's (value, written, abort) from it.
CanFrame encode_sdo_request(std::uint8_t node, const Sdo& sdo) noexcept;
CanFrame encode_sdo_reply(std::uint8_t node, const Sdo& sdo) noexcept;
/// Status: ok; malformed (size, reserved bits); not_supported (another identifier; a segmented or block
/// transfer, which nothing here asks for).
[[nodiscard]] Status decode_sdo_request(const CanFrame& frame, std::uint8_t& node, Sdo& sdo) noexcept;
[[nodiscard]] Status decode_sdo_reply(const CanFrame& frame, std::uint8_t& node, Sdo& sdo) noexcept;

/// `bytes` bytes, little endian; 0 to 4, inside the frame.
std::uint32_t read_le(const CanFrame& frame, unsigned first, unsigned bytes) noexcept;
void write_le(CanFrame& frame, unsigned first, unsigned bytes, std::uint32_t value) noexcept;

}  // namespace sortie::drivers::canopen
