// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can_flippers.hpp"

#include <cmath>

#include "drivers/can_raw.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kEnabled = 1u;
constexpr std::uint8_t kAll = 0x0F;

}  // namespace

Status encode_flippers(const rt::FlipperCommand& command, std::uint8_t counter, CanFrame out[2]) noexcept {
  const double limit = static_cast<double>(kCanAxisLimit) * kCanFlipperFields[0].scale;
  for (const double angle : command.angle_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
    if (std::fabs(angle) > limit) return Status::out_of_range;
  }
  for (std::uint32_t pair = 0; pair < 2; ++pair) {
    CanFrame& frame = out[pair];
    frame = blank(pair == 0 ? kCanFlipperFrontId : kCanFlipperRearId, command.stamp_ns);
    for (std::uint32_t side = 0; side < 2; ++side) {
      const CanSignal& field = kCanFlipperFields[side];
      write_can_field(frame, field, to_raw(command.angle_rad[2 * pair + side], field.scale));
    }
    write_can_field(frame, kCanFlipperFields[2], counter);
    write_can_field(frame, kCanFlipperFields[3], command.flags & kEnabled);
  }
  return Status::ok;
}

Status decode_flippers(const CanFrame& frame, FlipperPairCommand& command) noexcept {
  if ((frame.id != kCanFlipperFrontId && frame.id != kCanFlipperRearId) || frame.flags != 0)
    return Status::not_supported;
  if (frame.size != find_can_frame(frame.id)->size) return Status::malformed;
  const std::int64_t flags = read_can_field(frame, kCanFlipperFields[3]);
  if (flags > kEnabled) return Status::malformed;
  command.stamp_ns = frame.stamp_ns;
  command.pair = frame.id == kCanFlipperFrontId ? FlipperPair::front : FlipperPair::rear;
  command.left_rad = physical_can_field(frame, kCanFlipperFields[0]);
  command.right_rad = physical_can_field(frame, kCanFlipperFields[1]);
  command.flags = static_cast<std::uint32_t>(flags);
  command.counter = static_cast<std::uint8_t>(read_can_field(frame, kCanFlipperFields[2]));
  return Status::ok;
}

Status encode_flipper_state(const rt::FlipperSample& sample, std::uint16_t counter,
                            CanFrame out[rt::kFlippers]) noexcept {
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    if (!std::isfinite(sample.angle_rad[i]) || !std::isfinite(sample.torque_n_m[i]))
      return Status::not_finite;
  }
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    out[i] = blank(kCanFlipperStateId + i, sample.stamp_ns);
    write_can_field(out[i], kCanFlipperStateFields[0],
                    to_axis(sample.angle_rad[i], kCanFlipperStateFields[0].scale));
    write_can_field(out[i], kCanFlipperStateFields[1],
                    to_axis(sample.torque_n_m[i], kCanFlipperStateFields[1].scale));
    write_can_field(out[i], kCanFlipperStateFields[2], counter);
  }
  return Status::ok;
}

std::uint64_t FlipperJoin::add(std::uint32_t flipper, rt::Nanoseconds stamp_ns, std::int16_t angle,
                               std::int16_t torque, bool& complete) noexcept {
  const auto bit = static_cast<std::uint8_t>(1u << flipper);
  std::uint64_t dropped = 0;
  if (present_ != 0 && stamp_ns != stamp_ns_) {
    dropped = static_cast<std::uint64_t>(waiting());
    present_ = 0;
  } else if ((present_ & bit) != 0) {
    dropped = 1;
  }
  stamp_ns_ = stamp_ns;
  present_ = static_cast<std::uint8_t>(present_ | bit);
  angle_[flipper] = angle;
  torque_[flipper] = torque;
  complete = present_ == kAll;
  return dropped;
}

Status FlipperJoin::take(rt::FlipperSample& out) noexcept {
  present_ = 0;
  if (given_ && stamp_ns_ == last_ns_) return Status::time_repeated;
  if (given_ && stamp_ns_ < last_ns_) return Status::time_backwards;
  given_ = true;
  last_ns_ = stamp_ns_;
  out = {};
  out.stamp_ns = stamp_ns_;
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    out.angle_rad[i] = angle_[i] * kCanFlipperStateFields[0].scale;
    out.torque_n_m[i] = torque_[i] * kCanFlipperStateFields[1].scale;
  }
  return Status::ok;
}

}  // namespace sortie::drivers
