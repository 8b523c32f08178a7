// SPDX-License-Identifier: BSD-3-Clause
// Frames of a vehicle's CAN bus, written to the log as they come in.
#pragma once

#include "drivers/can_bus.hpp"
#include "firmware_like/runtime/vehicle.hpp"

namespace sortie::firmware {

/// Takes the oldest frame of `devices.can` and, if a log is kept, writes it there under CAN, so that
/// `export candump` finds it. For Vehicle::poll_devices. Status: ok, empty (nothing there, or the vehicle has
/// no bus), disconnected.
Status receive_can(const Devices& devices, rt::Nanoseconds now_ns, drivers::CanFrame& frame);

}  // namespace sortie::firmware
