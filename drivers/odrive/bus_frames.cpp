// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/odrive/ugv_axes.hpp"
#include "drivers/odrive_dbc.hpp"

namespace sortie::drivers::odrive {

// Frames of set-up and of states come rarely and are left out.
std::vector<CanStream> bus_frames(const UgvAxesConfig& config) {
  constexpr rt::Nanoseconds kEstimates = 10 * rt::kNanosecondsPerMillisecond;  // as an axis comes
  std::vector<CanStream> frames;
  const auto add = [&](const char* what, std::uint8_t node, const CanMessage& message,
                       rt::Nanoseconds period_ns) {
    CanStream frame;
    frame.name = std::string(what) + " of axis " + std::to_string(node);
    frame.id = message.id | static_cast<std::uint32_t>(node) << 5u;
    frame.size = message.size;
    frame.period_ns = period_ns;
    frames.push_back(std::move(frame));
  };
  const auto axis = [&](std::uint8_t node, bool flipper) {
    add("command", node, flipper ? kSetInputPos : kSetInputVel, config.line.period_ns);
    frames.back().queue = 0;  // ours leave through one interface
    add("estimates", node, kEncoderEstimates, kEstimates);
    if (flipper) add("current", node, kIq, kEstimates);
    add("heartbeat", node, kHeartbeat, config.silence_ns / 3);
  };
  for (const std::uint8_t node : config.track_nodes) axis(node, false);
  for (const std::uint8_t node : config.flipper_nodes) {
    if (config.flippers) axis(node, true);
  }
  return frames;
}

}  // namespace sortie::drivers::odrive
