// SPDX-License-Identifier: BSD-3-Clause
// The names on the wire in one place: channels, message types, and the fingerprint that begins each message.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace sortie::drivers {

/// Channels of a Sortie log and of its live telemetry.
inline constexpr std::string_view kChannelHeader = "SORTIE_HEADER";  ///< header_t, first event of a log
inline constexpr std::string_view kChannelTick = "SORTIE_TICK";      ///< tick_t, one per job that was decided
inline constexpr std::string_view kChannelTiming = "SORTIE_TIMING";  ///< timing_t, measured times of each job
inline constexpr std::string_view kChannelGap = "SORTIE_GAP";        ///< gap_t, the recorder lost events here
inline constexpr std::string_view kChannelEvent = "SORTIE_EVENT";    ///< event_t, something to know at once
inline constexpr std::string_view kChannelStats = "SORTIE_STATS";    ///< exec_stats_t, telemetry
inline constexpr std::string_view kChannelPools = "SORTIE_POOLS";    ///< pool_stats_t, telemetry
inline constexpr std::string_view kChannelParameters = "SORTIE_PARAMETERS";  ///< parameters_t, telemetry
inline constexpr std::string_view kChannelSet = "SORTIE_SET";      ///< set_parameter_t, requests to a run
inline constexpr std::string_view kChannelDrive = "SORTIE_DRIVE";  ///< drive_request_t, requests to a run
inline constexpr std::string_view kChannelFly = "SORTIE_FLY";      ///< fly_request_t, requests to a run
/// The next four are prefixes: "_" and a name follow.
inline constexpr std::string_view kChannelAnswers = "SORTIE_ANSWERS";  ///< request_answers_t, task that obeys
inline constexpr std::string_view kChannelFields = "SORTIE_FIELDS";    ///< fields_t, task
inline constexpr std::string_view kChannelChange = "PARAMETER";        ///< parameter_t, group
inline constexpr std::string_view kChannelCustom = "SORTIE_CUSTOM";    ///< custom_t, stream

inline constexpr std::string_view kChannelImu = "IMU";                 ///< imu_t
inline constexpr std::string_view kChannelTrack = "TRACK";             ///< track_t
inline constexpr std::string_view kChannelScan = "SCAN";               ///< scan_t
inline constexpr std::string_view kChannelSsl = "SSL";                 ///< ssl_returns_t
inline constexpr std::string_view kChannelSslCommand = "SSL_COMMAND";  ///< ssl_command_t, what was asked for
inline constexpr std::string_view kChannelTruth = "TRUTH";             ///< truth_t
inline constexpr std::string_view kChannelSensorTruth = "TRUTH_SENSORS";  ///< custom_t, rt::SensorTruth
inline constexpr std::string_view kChannelContacts = "TRUTH_CONTACTS";    ///< contacts_t
inline constexpr std::string_view kChannelSegments = "SEGMENTS";          ///< segments_t, telemetry
inline constexpr std::string_view kChannelLocated = "LOCATED";            ///< located_t, telemetry
inline constexpr std::string_view kChannelRecognised = "RECOGNISED";      ///< recognised_t, telemetry
inline constexpr std::string_view kChannelCan = "CAN";                    ///< can_t
inline constexpr std::string_view kChannelPose = "POSE_BODY";             ///< pose_t = bot_core.pose_t

/// Longest channel name that LCM carries, in bytes.
inline constexpr std::size_t kMaxChannelLength = 63;

/// First eight bytes of each message, big endian. They follow from the .lcm files (names and types of the
/// members, in order); a test compares them with what lcm-gen computes.
inline constexpr std::uint64_t kFingerprintImu = 0xf117808d97b15c43u;
inline constexpr std::uint64_t kFingerprintTrack = 0xc087e80207163cb7u;
inline constexpr std::uint64_t kFingerprintScan = 0x3669ca4d94ca6119u;
inline constexpr std::uint64_t kFingerprintTruth = 0x857761effb268982u;
inline constexpr std::uint64_t kFingerprintContacts = 0x3f28f37d16151ad3u;
inline constexpr std::uint64_t kFingerprintSegments = 0xcc25a32af3b44fcu;
inline constexpr std::uint64_t kFingerprintLocated = 0xa7339cd26dfa1f9u;
inline constexpr std::uint64_t kFingerprintRecognised = 0x478cdc5658dba481u;
inline constexpr std::uint64_t kFingerprintCan = 0x8bde5d53a3a8adc6u;
inline constexpr std::uint64_t kFingerprintHeader = 0xf5b99c7f3ae545a9u;
inline constexpr std::uint64_t kFingerprintTick = 0xf51359f53a9d9736u;
inline constexpr std::uint64_t kFingerprintTiming = 0x2235b9480ad1cac9u;
inline constexpr std::uint64_t kFingerprintGap = 0xc0490b69137a5f28u;
inline constexpr std::uint64_t kFingerprintEvent = 0xa545fb66088a957u;
inline constexpr std::uint64_t kFingerprintCustom = 0xb97c7f3f229f3220u;
inline constexpr std::uint64_t kFingerprintFields = 0x667a1249a4fd0d23u;
inline constexpr std::uint64_t kFingerprintExecStats = 0xe59ec1f3d581ca42u;
inline constexpr std::uint64_t kFingerprintPoolStats = 0xff28a1fe0e790983u;
inline constexpr std::uint64_t kFingerprintParameter = 0xbbe96bbd27937e90u;
inline constexpr std::uint64_t kFingerprintSetParameter = 0xd7d4ae612974e7bcu;
inline constexpr std::uint64_t kFingerprintParameters = 0x9314a8c6309c452eu;
inline constexpr std::uint64_t kFingerprintDriveRequest = 0xb636fb087d9ddc3cu;
inline constexpr std::uint64_t kFingerprintFlyRequest = 0xc27e3e5b1c4ad42bu;
inline constexpr std::uint64_t kFingerprintRequestAnswers = 0x54bf8ba8bee8abeu;
inline constexpr std::uint64_t kFingerprintSslCommand = 0xf91359d55a24fbfdu;
inline constexpr std::uint64_t kFingerprintSslReturns = 0x5462a43ba8317072u;
inline constexpr std::uint64_t kFingerprintPose = 0x2e16efb052b0105eu;

/// A message type that this program knows.
struct MessageType {
  std::string_view name;        ///< as in the .lcm file
  std::uint64_t fingerprint{};  ///< first eight bytes of the message
  std::string_view channel;     ///< where it is sent by default
};

/// Every message type. Order is the order in which tables show them.
inline constexpr std::array<MessageType, 27> kMessageTypes{{
    {"header_t", kFingerprintHeader, kChannelHeader},
    {"tick_t", kFingerprintTick, kChannelTick},
    {"timing_t", kFingerprintTiming, kChannelTiming},
    {"gap_t", kFingerprintGap, kChannelGap},
    {"event_t", kFingerprintEvent, kChannelEvent},
    {"imu_t", kFingerprintImu, kChannelImu},
    {"track_t", kFingerprintTrack, kChannelTrack},
    {"scan_t", kFingerprintScan, kChannelScan},
    {"ssl_returns_t", kFingerprintSslReturns, kChannelSsl},
    {"ssl_command_t", kFingerprintSslCommand, kChannelSslCommand},
    {"truth_t", kFingerprintTruth, kChannelTruth},
    {"contacts_t", kFingerprintContacts, kChannelContacts},
    {"segments_t", kFingerprintSegments, kChannelSegments},
    {"located_t", kFingerprintLocated, kChannelLocated},
    {"recognised_t", kFingerprintRecognised, kChannelRecognised},
    {"can_t", kFingerprintCan, kChannelCan},
    {"custom_t", kFingerprintCustom, kChannelCustom},
    {"fields_t", kFingerprintFields, kChannelFields},
    {"exec_stats_t", kFingerprintExecStats, kChannelStats},
    {"pool_stats_t", kFingerprintPoolStats, kChannelPools},
    {"parameters_t", kFingerprintParameters, kChannelParameters},
    {"set_parameter_t", kFingerprintSetParameter, kChannelSet},
    {"parameter_t", kFingerprintParameter, kChannelChange},
    {"drive_request_t", kFingerprintDriveRequest, kChannelDrive},
    {"fly_request_t", kFingerprintFlyRequest, kChannelFly},
    {"request_answers_t", kFingerprintRequestAnswers, kChannelAnswers},
    {"pose_t", kFingerprintPose, kChannelPose},
}};

/// Name of the type with this fingerprint, or an empty view. Cost: one pass over the table.
constexpr std::string_view type_name(std::uint64_t fingerprint) {
  for (const MessageType& type : kMessageTypes) {
    if (type.fingerprint == fingerprint) return type.name;
  }
  return {};
}

}  // namespace sortie::drivers
