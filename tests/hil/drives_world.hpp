// SPDX-License-Identifier: BSD-3-Clause
// The robot's drives of either protocol, simulated ones with axes to turn, and a bus between them: a value
// that can be copied at any moment, so that a test may try everything that can come next.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "drivers/can_frames.hpp"
#include "drivers/canopen/ugv_nodes.hpp"
#include "drivers/odrive/ugv_axes.hpp"
#include "drivers/odrive_dbc.hpp"
#include "hil/canopen/node.hpp"
#include "hil/drive_axis.hpp"
#include "hil/odrive/axis_node.hpp"

namespace sortie::hil::test {

/// A port whose frames the world carries. As SocketCAN's: so many frames fit, and off the bus none does.
class WorldPort final : public drivers::CanBus {
 public:
  explicit WorldPort(std::size_t room = 10) : room_(room) {}
  Status send(const drivers::CanFrame& frame) noexcept override {
    if (off) return Status::disconnected;
    if (frames.size() >= room_) return Status::full;
    frames.push_back(frame);
    return Status::ok;
  }
  Status receive(drivers::CanFrame&) noexcept override { return Status::empty; }
  drivers::CanCounters counters() const noexcept override { return {}; }

  std::vector<drivers::CanFrame> frames;
  bool off{};

 private:
  std::size_t room_;
};

/// CANopen: 10,000 increments a metre or radian.
struct CanopenKind {
  using Runtime = drivers::canopen::UgvNodes;
  using Config = drivers::canopen::UgvNodesConfig;
  using Node = CanopenNode;
  static constexpr const char* kName = "CANopen";
  static constexpr double kPerM = 10'000.0, kPerRad = 10'000.0;
  static CanopenNode make(std::uint8_t number, bool, drivers::CanBus& port) { return {number, port}; }
  static void show(CanopenNode& node, const DriveAxis& axis) {
    const auto whole = [](double value) { return static_cast<std::int32_t>(std::lround(value)); };
    node.show({whole(axis.position()), whole(axis.speed()), 0});
  }
  static bool torque(const CanopenNode& node) { return node.command().on; }
  /// Under torque and without fault, as far as the drive goes.
  static bool runs(const CanopenNode& node) {
    return node.state() == drivers::canopen::DriveState::operation_enabled;
  }
  /// Its target, where it runs: a speed, or a position. What holds has speed 0, or a target that stays.
  static double target(const CanopenNode& node, bool track) {
    return track ? node.command().velocity : node.command().position;
  }
  /// A fault counts from when it comes up: its emergency tells at once.
  static constexpr bool kTold = false;
  static bool tells_of_it(const drivers::CanFrame&) { return false; }
  static bool tells_fault(const drivers::CanFrame&) { return false; }
  static bool fed_since(const CanopenNode&, rt::Nanoseconds) { return true; }
  static void fault(CanopenNode& node) { node.fail(0x2310); }
  static bool has_fault(const CanopenNode& node) {
    return node.state() == drivers::canopen::DriveState::fault;
  }
  /// Alive and without readings: what heartbeats alone do not show.
  static void mute(CanopenNode& node, bool on) { node.set_no_readings(on); }
  static void block(CanopenNode& node, bool on) {
    node.set_block(on ? EnableBlock::safe_torque_off : EnableBlock::none);
  }
};

/// ODrive: 20 turns a metre, 16 a radian.
struct OdriveKind {
  using Runtime = drivers::odrive::UgvAxes;
  using Config = drivers::odrive::UgvAxesConfig;
  using Node = AxisNode;
  static constexpr const char* kName = "ODrive";
  static constexpr double kPerM = 20.0, kPerRad = 16.0;
  static AxisNode make(std::uint8_t number, bool track, drivers::CanBus& port) {
    return {AxisNodeConfig{.node = number, .absolute = !track, .fastest_turn_s2 = track ? 80.0 : 160.0},
            port};
  }
  static void show(AxisNode& node, const DriveAxis& axis) { node.show({axis.position(), axis.speed(), 0.0}); }
  static bool torque(const AxisNode& node) { return node.command().on; }
  static bool runs(const AxisNode& node) { return node.command().on && node.error() == 0; }
  static double target(const AxisNode& node, bool track) {
    return track ? node.command().turns_s : node.command().turns;
  }
  static constexpr std::uint32_t kFault = 0x40;
  static void fault(AxisNode& node) { node.fail(kFault); }
  /// CANSimple answers nothing, so a fault is known from the first heartbeat that tells of it: one that a
  /// set-up has forgotten before is none (docs/odrive.md).
  static constexpr bool kTold = true;
  /// An axis under torque that is sent nothing is being proved, and an error then looks like its watchdog's
  /// (docs/odrive.md).
  static bool fed_since(const AxisNode& node, rt::Nanoseconds ns) { return node.fed_ns() > ns; }
  static bool tells_of_it(const drivers::CanFrame& frame) {
    return frame.id == (1u << 5u | drivers::odrive::kHeartbeat.id);
  }
  static bool tells_fault(const drivers::CanFrame& frame) {
    return tells_of_it(frame) &&
           (drivers::read_can_field(frame, drivers::odrive::kHeartbeatSignals[0]) & kFault) != 0;
  }
  static bool has_fault(const AxisNode& node) { return node.error() != 0; }
  static void mute(AxisNode& node, bool on) { node.set_mute(on); }
  static void block(AxisNode& node, bool on) { node.set_calibrated(!on); }
};

/// The world. One call of step() is a millisecond.
template <class Kind>
class DrivesWorld {
  using Runtime = typename Kind::Runtime;

 public:
  static constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
  static constexpr int kFramesPerMs = 4;  ///< of ours, at 500 kbit/s

  explicit DrivesWorld(bool flippers = false, const typename Kind::Config& config = {}, double slope_s2 = 0.0)
      : runtime_(with(config, flippers)), flippers_(flippers) {
    theirs_.frames.reserve(64);
    const std::vector<std::uint8_t> numbers =
        flippers ? std::vector<std::uint8_t>{1, 2, 11, 12, 13, 14} : std::vector<std::uint8_t>{1, 2};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double unit = i < 2 ? Kind::kPerM : Kind::kPerRad;
      nodes_.push_back(Kind::make(numbers[i], i < 2, theirs_));
      // The motor gives 6 m/s^2, friction takes 0.5; a flipper is light and its gear rubs.
      axes_.emplace_back(DriveAxisConfig{.motor_s2 = (i < 2 ? 6.0 : 60.0) * unit,
                                         .friction_s2 = (i < 2 ? 0.5 : 20.0) * unit,
                                         .slope_s2 = i < 2 ? slope_s2 * unit : 0.0});
    }
    drive_.left_m_s = 0.5;
    drive_.right_m_s = -0.4;
  }
  DrivesWorld(const DrivesWorld& other)
      : drive_(other.drive_),
        flipper_(other.flipper_),
        swing_rad_(other.swing_rad_),
        drive_speaks_(other.drive_speaks_),
        flippers_speak_(other.flippers_speak_),
        lives_(other.lives_),
        starved_(other.starved_),
        tracks_(other.tracks_),
        runtime_(other.runtime_),
        flippers_(other.flippers_),
        ours_(other.ours_),
        theirs_(other.theirs_),
        nodes_(other.nodes_),
        axes_(other.axes_),
        inbox_(other.inbox_),
        targets_(other.targets_),
        ran_(other.ran_),
        fault_told_ns_(other.fault_told_ns_),
        fault_shown_(other.fault_shown_),
        now_(other.now_) {
    for (auto& node : nodes_) node.set_port(theirs_);
  }
  DrivesWorld& operator=(const DrivesWorld&) = delete;

  void run(int ms) {
    for (int i = 0; i < ms; ++i) step();
  }
  void step() {
    now_ += kMs;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      ran_[i] = runs(i);
      targets_[i] = Kind::target(nodes_[i], i < 2);
    }
    if (lives_ && !starved_) poll();
    carry();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      nodes_[i].step(now_);
      axes_[i].advance(nodes_[i].wish(), 1e-3);
      Kind::show(nodes_[i], axes_[i]);
    }
    collect();
  }

  /// The process is killed, and another begins.
  void restart(typename Kind::Config config = {}) {
    drive_.asked = flipper_.asked = 0;  // with the program its numbers begin anew
    runtime_.~Runtime();
    new (&runtime_) Runtime(with(config, flippers_));
    inbox_.clear();
  }
  /// A request as an operator makes one by halt and release: off, then on, with a new number.
  void request() {
    ask(false);
    run(15);
    ask(true);
  }
  void ask(bool on) {
    ask_drive(on);
    ask_flippers(on);
  }
  /// One source alone. On after off is a request; on again is none.
  void ask_drive(bool on) { ask_one(drive_, on); }
  void ask_flippers(bool on) { ask_one(flipper_, on); }
  /// From power-on until they run.
  bool bring_up() {
    ask(false);
    run(3000);
    ask(true);
    run(800);
    return runtime_.running();
  }
  bool torque() const {
    return std::any_of(nodes_.begin(), nodes_.end(), [](const auto& n) { return Kind::torque(n); });
  }
  bool runs(std::size_t i) const { return Kind::runs(nodes_[i]); }
  /// It runs, and follows: a track a speed, a flipper a target that has moved in this millisecond.
  bool driven(std::size_t i) const {
    if (!runs(i)) return false;
    const double target = Kind::target(nodes_[i], i < 2) / unit(i);
    return i < 2 ? std::fabs(target) > 1e-6 : ran_[i] && std::fabs(target - targets_[i] / unit(i)) > 1e-3;
  }
  /// In m/s, or rad/s; metres, or radians.
  double speed(std::size_t i) const { return axes_[i].speed() / unit(i); }
  double position(std::size_t i) const { return axes_[i].position() / unit(i); }
  static double unit(std::size_t i) { return i < 2 ? Kind::kPerM : Kind::kPerRad; }

  typename Kind::Runtime& runtime() { return runtime_; }
  const typename Kind::Runtime& runtime() const { return runtime_; }
  typename Kind::Node& node(std::size_t i) { return nodes_[i]; }
  DriveAxis& axis(std::size_t i) { return axes_[i]; }
  std::size_t size() const { return nodes_.size(); }
  rt::Nanoseconds now() const { return now_; }
  /// When the runtime's side last got a frame that tells of a fault.
  rt::Nanoseconds fault_told_ns() const { return fault_told_ns_; }
  /// The newest of the first drive's told of one: until another tells of none, a new one looks like that.
  bool fault_shown() const { return fault_shown_; }
  bool bus_off() const { return ours_.off; }
  void set_bus_off(bool off) {
    ours_.off = off;
    if (off) ours_.frames.clear();
  }

  // What the rest of the program, and fate, do in every millisecond.
  rt::DriveCommand drive_{};
  rt::FlipperCommand flipper_{};
  double swing_rad_{};  ///< flippers go to and fro so far, once in two seconds
  bool drive_speaks_{true};
  bool flippers_speak_{true};
  bool lives_{true};
  bool starved_{};            ///< the process is there and does not run
  rt::TrackSample tracks_{};  ///< the newest

 private:
  template <class Command>
  static void ask_one(Command& command, bool on) {
    if (on && command.flags == 0) ++command.asked;
    command.flags = on ? 1u : 0u;
  }
  static typename Kind::Config with(typename Kind::Config config, bool flippers) {
    config.flippers = flippers;
    return config;
  }
  void poll() {
    for (const drivers::CanFrame& frame : inbox_) static_cast<void>(runtime_.take(frame, now_));
    inbox_.clear();
    drive_.stamp_ns = flipper_.stamp_ns = now_;
    if (swing_rad_ > 0.0) {
      const double at = swing_rad_ * std::sin(3.14159e-9 * static_cast<double>(now_));
      std::fill(std::begin(flipper_.angle_rad), std::end(flipper_.angle_rad), at);
    }
    // Commands of this moment; what the runtime does not take, it counts.
    if (drive_speaks_) static_cast<void>(runtime_.set(drive_, now_));
    if (flippers_ && flippers_speak_) static_cast<void>(runtime_.set(flipper_, now_));
    runtime_.poll(now_, ours_);
    static_cast<void>(runtime_.read(tracks_));  // empty: the one before stays
  }
  void carry() {
    const std::size_t count = std::min<std::size_t>(ours_.frames.size(), kFramesPerMs);
    for (std::size_t k = 0; k < count; ++k) {
      for (auto& node : nodes_) node.hear(ours_.frames[k], now_);
    }
    ours_.frames.erase(ours_.frames.begin(), ours_.frames.begin() + static_cast<std::ptrdiff_t>(count));
  }
  void collect() {
    for (drivers::CanFrame& frame : theirs_.frames) {
      frame.stamp_ns = now_;
      if (ours_.off || !lives_ || inbox_.size() >= 256) continue;
      inbox_.push_back(frame);
      if (Kind::tells_fault(frame)) fault_told_ns_ = now_;
      if (Kind::tells_of_it(frame)) fault_shown_ = Kind::tells_fault(frame);
    }
    theirs_.frames.clear();
  }

  typename Kind::Runtime runtime_;
  bool flippers_;
  WorldPort ours_{10};
  WorldPort theirs_{1000};
  std::vector<typename Kind::Node> nodes_;
  std::vector<DriveAxis> axes_;
  std::vector<drivers::CanFrame> inbox_;
  std::array<double, 6> targets_{};  // before this millisecond, in the drives' units
  std::array<bool, 6> ran_{};
  rt::Nanoseconds fault_told_ns_{-1};
  bool fault_shown_{};
  rt::Nanoseconds now_{};
};

/// How far the faster wheel goes in this time, m.
template <class World>
double way(World& world, int ms) {
  const double from[] = {world.position(0), world.position(1)};
  world.run(ms);
  return std::max(std::fabs(world.position(0) - from[0]), std::fabs(world.position(1) - from[1]));
}

}  // namespace sortie::hil::test
