// SPDX-License-Identifier: BSD-3-Clause
// The way to a solid-state lidar and back: lists of rays out, ranges in. And a link in memory for a simulated
// one.
#pragma once

#include <algorithm>

#include "rt/spsc_ring.hpp"
#include "rt/ssl_samples.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// The vehicle's end of the link to the device. One thread at a time. No call blocks, allocates or throws.
class SslPort {
 public:
  virtual ~SslPort() = default;
  /// Asks for a frame. Status: ok; out_of_range (more rays than a frame has, or a direction that the grid
  /// does not have: nothing is sent); full (the device has not taken those before).
  [[nodiscard]] virtual Status send(const rt::SslCommand& command) noexcept = 0;
  /// The oldest frame that has come. Status: ok; empty.
  [[nodiscard]] virtual Status receive(rt::SslReturns& returns) noexcept = 0;
};

/// True if the device can fire a command, or have fired what it returns: no more rays than a frame has, and
/// all within the grid.
constexpr bool can_be_fired(const auto& sample) {
  return sample.rays <= rt::kSslMaxRays &&
         std::all_of(sample.direction, sample.direction + sample.rays,
                     [](std::uint16_t direction) { return direction < rt::kSslDirections; });
}

/// Both ends in memory, each for a thread of its own. About 9 kB, no heap.
class SslStub final : public SslPort {
 public:
  [[nodiscard]] Status send(const rt::SslCommand& command) noexcept override {
    if (!can_be_fired(command)) return Status::out_of_range;
    return commands_.try_push(command) ? Status::ok : Status::full;
  }
  [[nodiscard]] Status receive(rt::SslReturns& returns) noexcept override {
    return returns_.try_pop(returns) ? Status::ok : Status::empty;
  }

  /// The device's end: the oldest command. Status: ok; empty.
  [[nodiscard]] Status take(rt::SslCommand& command) noexcept {
    return commands_.try_pop(command) ? Status::ok : Status::empty;
  }
  /// The device's end: hands a frame over. Status: ok; full (it is lost).
  [[nodiscard]] Status deliver(const rt::SslReturns& returns) noexcept {
    return returns_.try_push(returns) ? Status::ok : Status::full;
  }

 private:
  rt::SpscRing<rt::SslCommand, 4> commands_;
  rt::SpscRing<rt::SslReturns, 4> returns_;
};

}  // namespace sortie::drivers
