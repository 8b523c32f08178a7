// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: the robot's motors on ODrives beside honest axes, while the input injects frames,
// loses and changes what is on the bus, cuts power and lets time pass. What goes out must be legal and
// bounded, nothing runs while it is stopped or not asked for, samples are finite and in order, and when the
// disturbance is over, the axes run again.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <vector>

#include "drivers/odrive/ugv_axes.hpp"
#include "hil/odrive/axis_node.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::drivers::odrive;

namespace {

constexpr std::uint8_t kNodes[] = {1, 2, 11, 12, 13, 14};

void require(bool condition) {
  if (!condition) std::abort();
}

// What a port is given, until the bus carries it.
class FuzzPort final : public CanBus {
 public:
  Status send(const CanFrame& frame) noexcept override {
    require(frame.id < 0x800 && frame.size == 8 && frame.flags == 0);
    if (refuses) return Status::full;
    frames.push_back(frame);
    return Status::ok;
  }
  Status receive(CanFrame&) noexcept override { return Status::empty; }
  CanCounters counters() const noexcept override { return {}; }

  std::vector<CanFrame> frames;
  bool refuses{};
};

struct FuzzRobot {
  FuzzRobot() {
    axes.reserve(std::size(kNodes));
    for (const std::uint8_t number : kNodes) {
      hil::AxisNodeConfig config;
      config.node = number;
      axes.emplace_back(config, axes_port);
    }
    drive.left_m_s = 0.25;
    drive.right_m_s = -0.25;
  }

  void enable(bool on) {
    enabled = on;
    if (on && drive.flags == 0) ++drive.asked;
    drive.flags = on ? 1 : 0;
    require(motors.set(drive, now_ns) == Status::ok);
  }

  // A millisecond of the bus.
  void step() {
    now_ns += rt::kNanosecondsPerMillisecond;
    motors.poll(now_ns, port);
    require(port.frames.size() <= std::size_t{AxisLine::kBurst + 1});
    for (CanFrame& frame : port.frames) {
      disturb(frame);
      for (hil::AxisNode& axis : axes) axis.hear(frame, now_ns);
    }
    port.frames.clear();
    for (hil::AxisNode& axis : axes) axis.step(now_ns);
    for (CanFrame& frame : axes_port.frames) {
      if (lose > 0) {
        --lose;
        continue;
      }
      disturb(frame);
      frame.stamp_ns = now_ns;
      static_cast<void>(motors.take(frame, now_ns));
    }
    axes_port.frames.clear();
    look();
  }

  void disturb(CanFrame& frame) {
    if (change != 0) frame.data[change & 7] ^= change;
    change = 0;
  }

  void look() {
    // Commands are renewed by the input alone, so a run may also end by their age.
    if (pressed || !enabled) require(!motors.running() || !settled);
    settled = true;
    rt::TrackSample track;
    if (motors.read(track) == Status::ok) {
      require(track.stamp_ns > last_track_ns && std::isfinite(track.left_m) && std::isfinite(track.right_m));
      last_track_ns = track.stamp_ns;
    }
    rt::FlipperSample flippers;
    if (motors.read(flippers) == Status::ok) {
      for (const double angle : flippers.angle_rad) require(std::isfinite(angle));
    }
  }

  FuzzPort port;
  FuzzPort axes_port;
  UgvAxes motors{UgvAxesConfig{}};
  std::vector<hil::AxisNode> axes;
  rt::DriveCommand drive;
  rt::Nanoseconds now_ns{};
  rt::Nanoseconds last_track_ns{std::numeric_limits<rt::Nanoseconds>::min()};
  std::uint8_t lose{};
  std::uint8_t change{};
  bool pressed{};
  bool enabled{};
  bool settled{};  // a cycle has passed since it was pressed or switched off
};

// Most choices name a frame that some axis could send, so that the fuzzer needs not find identifiers.
std::uint32_t id_of(std::uint8_t choice) {
  constexpr std::uint32_t kCommands[] = {0x01, 0x09, 0x14, 0x07, 0x0B, 0x0C, 0x0D, 0x18};
  return choice >= 0xC0 ? choice * 7u
                        : kCommands[choice & 7] |
                              static_cast<std::uint32_t>(kNodes[(choice >> 3) % std::size(kNodes)]) << 5u;
}

void act(FuzzRobot& robot, const std::uint8_t* in) {
  CanFrame frame;
  frame.id = id_of(in[2]);
  frame.size = (in[1] & 0x10) != 0 ? static_cast<std::uint8_t>(in[1] & 0x0F) : 8;
  frame.stamp_ns = robot.now_ns;
  std::memcpy(frame.data, in + 3, 8);
  hil::AxisNode& axis = robot.axes[in[2] % std::size(kNodes)];
  const bool on = (in[1] & 1) != 0;
  switch (in[1] >> 5) {
    case 0:
    case 1:
      static_cast<void>(robot.motors.take(frame, robot.now_ns));
      break;
    case 2:
      for (hil::AxisNode& node : robot.axes) node.hear(frame, robot.now_ns);
      break;
    case 3:
      robot.enable(on);
      break;
    case 4: {
      rt::DriveCommand command = robot.drive;
      std::memcpy(&command.left_m_s, in + 3, sizeof command.left_m_s);
      const Status wanted = std::isfinite(command.left_m_s) ? Status::ok : Status::not_finite;
      require(robot.motors.set(command, robot.now_ns) == wanted);
      break;
    }
    case 5:
      robot.pressed = on;
      robot.motors.press(on);
      break;
    case 6:
      robot.lose = in[2];
      robot.change = in[3];
      robot.port.refuses = on;
      break;
    default:
      if (on) axis.set_power((in[1] & 2) != 0);
      if ((in[1] & 4) != 0) axis.set_mute((in[1] & 8) != 0);
      if ((in[1] & 16) != 0) axis.fail(in[3] | 1u, in[4] & 3);
      break;
  }
  robot.settled = false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostDeeds = 200;
  FuzzRobot robot;
  for (int i = 0; i < 600; ++i) robot.step();  // set up, and proved
  for (std::size_t at = 0; at + 11 <= size && at < 11 * kMostDeeds; at += 11) {
    act(robot, data + at);
    for (int ms = 0; ms < (data[at] & 31); ++ms) robot.step();
  }
  // Whatever happened: the bus is whole again, all axes have power, and they are asked anew.
  robot.lose = robot.change = 0;
  robot.port.refuses = false;
  robot.pressed = false;
  robot.motors.press(false);
  for (hil::AxisNode& axis : robot.axes) {
    axis.set_mute(false);
    axis.set_power(false);
    axis.set_power(true);
  }
  bool ran = false;
  for (int ms = 0; ms < 8000 && !ran; ++ms) {
    if (ms % 100 == 0) robot.enable(ms % 1000 >= 100);
    robot.step();
    ran = robot.motors.running();
  }
  require(ran);
  return 0;
}
