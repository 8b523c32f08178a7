// SPDX-License-Identifier: BSD-3-Clause
// The messages of samples, and of a robot's place on its map. encode() and decode() are those of
// wire_fields.hpp, but for the decoder of scans; for any thread, no heap.
#pragma once

#include "drivers/can_bus.hpp"
#include "drivers/channels.hpp"
#include "drivers/wire_fields.hpp"
#include "rt/located_pose.hpp"
#include "rt/recognised_place.hpp"
#include "rt/samples.hpp"

namespace sortie::drivers {

template <>
struct WireRules<rt::ImuSample> : WireNumbered {};
template <>
struct WireRules<rt::TrackSample> : WireNumbered {};
template <>
struct WireRules<rt::TruthSample> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("p", self.p_world_body_m);
    visit("q", self.q_world_body);
    visit("flags", self.flags);
  }
};
template <>
struct WireRules<CanFrame> : WirePlain {
  static constexpr bool taken(const CanFrame& frame) { return frame.size <= 8; }
};
template <>
struct WireRules<rt::LocatedPose> : WireNumbered {
  static bool taken(const rt::LocatedPose& pose) { return pose.weak_moves <= 3 && pose.weak_turns <= 3; }
};
template <>
struct WireRules<rt::RecognisedPlace> : WireNumbered {};
/// What stands before the points.
template <>
struct WireRules<rt::ScanHeader> : WireNumbered {
  static constexpr void members(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("flags", self.flags);
    visit("p_world_sensor_m", self.p_world_sensor_m);
    visit("q_world_sensor", self.q_world_sensor);
    visit("n", self.points);
  }
};
template <>
struct WireRules<rt::ScanPoint> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("xyz", joined(self.x_m, self.y_m, self.z_m));
    visit("intensity", self.intensity);
    visit("age_10us", self.age_10us);
  }
};
template <>
struct WireRules<rt::PointScan> : WireNumbered {
  static constexpr void members(auto& self, auto&& visit) {
    visit_members(self.header, visit);
    visit("points", counted("n", std::span(self.points, self.header.points), self.header.points));
  }
};

/// Message sizes in bytes, fingerprint included.
inline constexpr std::size_t kImuBytes = kLeastBytes<rt::ImuSample>;
inline constexpr std::size_t kTrackBytes = kLeastBytes<rt::TrackSample>;
inline constexpr std::size_t kTruthBytes = kLeastBytes<rt::TruthSample>;
inline constexpr std::size_t kCanBytes = kLeastBytes<CanFrame>;
inline constexpr std::size_t kLocatedBytes = kLeastBytes<rt::LocatedPose>;
inline constexpr std::size_t kRecognisedBytes = kLeastBytes<rt::RecognisedPlace>;
inline constexpr std::size_t kScanHeadBytes = kLeastBytes<rt::PointScan>;
inline constexpr std::size_t kScanPointBytes = 16;

/// Bytes of a scan message with `points` points.
constexpr std::size_t scan_bytes(std::size_t points) { return kScanHeadBytes + points * kScanPointBytes; }

/// Points go to the front of `points`; more of them than it holds is `full`, and then `header` and `seq`
/// alone are set (the former's `points` says how many there are).
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::ScanHeader& header,
                            std::span<rt::ScanPoint> points, std::int64_t& seq) noexcept;

}  // namespace sortie::drivers
