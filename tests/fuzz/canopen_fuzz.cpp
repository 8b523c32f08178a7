// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: the robot's drives on CANopen beside honest drives, while the input injects frames,
// loses, changes and delays what is on the bus, cuts power and lets time pass. What goes out must be legal
// and bounded, nothing runs while it is stopped or not asked for, samples are finite and in order, and when
// the disturbance is over, the drives run again.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <vector>

#include "drivers/canopen/ugv_nodes.hpp"
#include "hil/canopen/node.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::drivers::canopen;

namespace {

constexpr int kMostFramesPerPoll = 4 + 2 * static_cast<int>(kMaxDrives);
constexpr std::uint8_t kNodes[] = {1, 2, 11, 12, 13, 14};

void require(bool condition) {
  if (!condition) std::abort();
}

// What a port is given lies here until the bus carries it.
class Port final : public CanBus {
 public:
  Status send(const CanFrame& frame) noexcept override {
    require(frame.id < 0x800 && frame.size <= 8 && frame.flags == 0);
    if (refuses || count_ == kMost) return Status::full;
    queue_[count_++] = frame;
    return Status::ok;
  }
  Status receive(CanFrame&) noexcept override { return Status::empty; }
  CanCounters counters() const noexcept override { return {}; }
  template <class F>
  int drain(F put) {
    const int count = count_;
    count_ = 0;
    CanFrame frames[kMost];
    for (int i = 0; i < count; ++i) frames[i] = queue_[i];
    for (int i = 0; i < count; ++i) put(frames[i]);
    return count;
  }
  bool refuses{};

 private:
  static constexpr int kMost = 64;
  CanFrame queue_[kMost];
  int count_{};
};

class Robot {
 public:
  Robot() {
    nodes_.reserve(std::size(kNodes));
    for (const std::uint8_t number : kNodes) nodes_.emplace_back(number, drives_port_);
    command_.left_m_s = 0.25;
    command_.right_m_s = -0.25;
  }
  void inject(const CanFrame& frame) { static_cast<void>(ours_.take(frame, now_ns_)); }
  void inject_to_drives(const CanFrame& frame) {
    for (hil::CanopenNode& node : nodes_) node.hear(frame, now_ns_);
  }
  void enable(bool on) {
    if (on && command_.flags == 0) ++command_.asked;
    command_.flags = on ? 1 : 0;
    enabled_ = on;
    require(ours_.set(command_, now_ns_) == Status::ok);
  }
  void set_speed(double left_m_s) {
    rt::DriveCommand command = command_;
    command.left_m_s = left_m_s;
    const bool finite = std::isfinite(left_m_s);
    require(ours_.set(command, now_ns_) == (finite ? Status::ok : Status::not_finite));
  }
  void press(bool pressed) {
    pressed_ = pressed;
    ours_.press(pressed);
  }
  void lose(std::uint8_t next) { lose_ = next; }
  void change(std::uint8_t bits) { change_ = bits; }
  void refuse(bool on) { ours_port_.refuses = on; }
  hil::CanopenNode& node(std::uint8_t i) { return nodes_[i % nodes_.size()]; }
  bool running() const { return ours_.running(); }

  // A millisecond of the bus.
  void step() {
    now_ns_ += rt::kNanosecondsPerMillisecond;
    for (hil::CanopenNode& node : nodes_) node.show({});
    ours_.poll(now_ns_, ours_port_);
    // Before new frames come: what they say is decided upon at the next poll.
    for (std::size_t i = 0; i < ours_.line().size(); ++i)
      require(!running() || ours_.line().drive(i).phase() != DrivePhase::setting_up);
    const int sent = ours_port_.drain([this](CanFrame frame) {
      disturb(frame);
      for (hil::CanopenNode& node : nodes_) node.hear(frame, now_ns_);
    });
    require(sent <= kMostFramesPerPoll);
    for (hil::CanopenNode& node : nodes_) node.step(now_ns_);
    drives_port_.drain([this](CanFrame frame) {
      if (lose_ > 0) {
        --lose_;
        return;
      }
      disturb(frame);
      frame.stamp_ns = now_ns_;
      static_cast<void>(ours_.take(frame, now_ns_));
    });
    look();
  }

 private:
  void disturb(CanFrame& frame) {
    if (change_ == 0) return;
    frame.data[change_ & 7] ^= change_;
    change_ = 0;
  }
  void look() {
    if (pressed_ || !enabled_) require(!ours_.running());
    rt::TrackSample track;
    if (ours_.read(track) == Status::ok) {
      require(track.stamp_ns > last_track_ns_ && std::isfinite(track.left_m) && std::isfinite(track.right_m));
      last_track_ns_ = track.stamp_ns;
    }
    rt::FlipperSample flippers;
    if (ours_.read(flippers) == Status::ok) {
      for (const auto angle : flippers.angle_rad) require(std::isfinite(angle));
    }
  }
  Port ours_port_;
  Port drives_port_;
  UgvNodes ours_{UgvNodesConfig{}};
  std::vector<hil::CanopenNode> nodes_;
  rt::DriveCommand command_;
  rt::Nanoseconds now_ns_{};
  rt::Nanoseconds last_track_ns_{std::numeric_limits<rt::Nanoseconds>::min()};
  std::uint8_t lose_{};
  std::uint8_t change_{};
  bool pressed_{};
  bool enabled_{};
};

// Most choices name a frame that some drive could send, so that the fuzzer needs not find identifiers.
std::uint32_t id_of(std::uint8_t choice) {
  constexpr std::uint32_t kFunctions[] = {0x000, 0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700};
  return choice >= 0xC0 ? choice * 7u : kFunctions[choice & 7] + kNodes[(choice >> 3) % std::size(kNodes)];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostDeeds = 200;
  Robot robot;
  for (int i = 0; i < 40; ++i) robot.step();  // most of the set-up
  for (std::size_t at = 0; at + 11 <= size && at < 11 * kMostDeeds; at += 11) {
    const std::uint8_t* const in = data + at;
    CanFrame frame;
    frame.id = id_of(in[2]);
    frame.size = (in[1] & 0x10) != 0 ? static_cast<std::uint8_t>(in[1] & 0x0F) : 8;
    std::memcpy(frame.data, in + 3, 8);
    double speed = 0;
    std::memcpy(&speed, in + 3, sizeof speed);
    switch (in[1] >> 5) {
      case 0:
      case 1:
        robot.inject(frame);
        break;
      case 2:
        robot.inject_to_drives(frame);
        break;
      case 3:
        robot.enable((in[1] & 1) != 0);
        break;
      case 4:
        robot.set_speed(speed);
        break;
      case 5:
        robot.press((in[1] & 1) != 0);
        break;
      case 6:
        robot.lose(in[2]);
        robot.change(in[3]);
        robot.refuse((in[1] & 1) != 0);
        break;
      default:
        if ((in[1] & 1) != 0) robot.node(in[2]).set_power((in[1] & 2) != 0);
        if ((in[1] & 4) != 0) robot.node(in[2]).set_mute((in[1] & 8) != 0);
        if ((in[1] & 16) != 0) robot.node(in[2]).fail(static_cast<std::uint16_t>(0x2000 + in[3]), in[4] & 3);
        break;
    }
    for (int ms = 0; ms < (in[0] & 31); ++ms) robot.step();
  }
  // Whatever happened: the bus is whole again, all drives have power, and they are asked anew.
  robot.lose(0);
  robot.change(0);
  robot.refuse(false);
  robot.press(false);
  for (std::uint8_t i = 0; i < std::size(kNodes); ++i) {
    robot.node(i).set_mute(false);
    robot.node(i).set_power(false);
    robot.node(i).set_power(true);
  }
  bool ran = false;
  for (int ms = 0; ms < 6000 && !ran; ++ms) {
    if (ms % 100 == 0) robot.enable(ms % 1000 >= 100);
    robot.step();
    ran = robot.running();
  }
  require(ran);
  return 0;
}
