// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/own_frames.hpp"

#include "drivers/can_frames.hpp"

namespace sortie::firmware {

void add_own_frames(VehicleBuilder& builder, std::span<const std::uint32_t> ids, rt::Nanoseconds period_ns,
                    int queue) {
  std::vector<drivers::CanStream> frames;
  for (const std::uint32_t id : ids) {
    const drivers::CanMessage* const message = drivers::find_can_frame(id);
    frames.push_back(
        {.name = message->name, .id = id, .size = message->size, .period_ns = period_ns, .queue = queue});
  }
  builder.bus_frames(std::move(frames));
}

void add_device_frames(VehicleBuilder& builder, std::span<const std::uint32_t> ids, const char* key,
                       double usual_hz, const char* device) {
  const double hz = builder.profile().number(key, {usual_hz, 0.1, 10'000, "Hz", device});
  add_own_frames(builder, ids, static_cast<rt::Nanoseconds>(1e9 / hz), -1);
}

}  // namespace sortie::firmware
