// SPDX-License-Identifier: BSD-3-Clause
#include "hil/motor_wishes.hpp"

namespace sortie::hil {

void tell_body(VehicleBody& body, const MotorWishes& wishes, rt::Nanoseconds now_ns) noexcept {
  rt::DriveCommand drive;
  drive.stamp_ns = now_ns;
  drive.left_m_s = wishes.track_m_s[0];
  drive.right_m_s = wishes.track_m_s[1];
  drive.flags = 1;
  static_cast<void>(body.set_command(drive, now_ns));  // finite by construction
  body.let_go(!wishes.track_on[0], !wishes.track_on[1]);
  if (!wishes.flippers) return;
  for (std::size_t left = 0; left < rt::kFlippers; left += 2) {
    drivers::FlipperPairCommand flippers;
    flippers.stamp_ns = now_ns;
    flippers.pair = left == 0 ? drivers::FlipperPair::front : drivers::FlipperPair::rear;
    flippers.left_rad = wishes.angle_rad[left];
    flippers.right_rad = wishes.angle_rad[left + 1];
    flippers.flags = wishes.moves[left] && wishes.moves[left + 1] ? 1u : 0u;
    static_cast<void>(body.set_flippers(flippers));
  }
}

}  // namespace sortie::hil
