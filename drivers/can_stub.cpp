// SPDX-License-Identifier: BSD-3-Clause
// The CAN bus in memory: set-up. What happens while it runs is in can_stub_run.cpp.
#include "drivers/can_stub.hpp"

#include <bit>
#include <stdexcept>
#include <string>

#include "drivers/can_stub_node.hpp"

namespace sortie::drivers {

namespace {

constexpr std::size_t kMaxNodes = 32;
constexpr std::uint32_t kMaxQueue = 1u << 20;

/// A probability as a limit for 53-bit draws.
std::uint64_t draw_limit(double probability, const char* name) {
  if (!(probability >= 0.0 && probability <= 1.0)) {
    throw std::runtime_error(std::string("CAN stub: fault '") + name + "' must be a probability from 0 to 1");
  }
  return static_cast<std::uint64_t>(probability * 9007199254740992.0);
}

std::uint32_t queue_size(std::uint32_t frames, const char* name) {
  if (frames == 0 || frames > kMaxQueue) {
    throw std::runtime_error(std::string("CAN stub: ") + name + " must lie in 1..1048576");
  }
  return std::bit_ceil(frames);
}

}  // namespace

CanStub::CanStub(const CanStubConfig& config) : config_(config) {
  constexpr std::uint32_t kBillion = 1'000'000'000;
  if (config.bitrate < 1'000 || config.bitrate > 1'000'000 || kBillion % config.bitrate != 0) {
    throw std::runtime_error("CAN stub: bit rate " + std::to_string(config.bitrate) +
                             " is not usable; give one from 1000 to 1000000 bit/s that divides 1e9, such as "
                             "125000, 250000, 500000 or 1000000");
  }
  config_.tx_frames = queue_size(config.tx_frames, "tx_frames");
  config_.rx_frames = queue_size(config.rx_frames, "rx_frames");
  bit_ns_ = kBillion / config.bitrate;
  set_faults(config.faults);
  last_advance_ns_ = config.start_ns;
  bus_free_ns_ = config.start_ns;
  nodes_.reserve(kMaxNodes);
}

CanStub::~CanStub() = default;

CanBus& CanStub::attach(const std::string& name) {
  if (started_) throw std::runtime_error("CAN stub: node '" + name + "' comes after the bus has started");
  if (nodes_.size() == kMaxNodes)
    throw std::runtime_error("CAN stub: no room for node '" + name + "', 32 at most");
  for (const auto& node : nodes_) {
    if (node->name == name) throw std::runtime_error("CAN stub: a node named '" + name + "' exists already");
  }
  nodes_.push_back(std::make_unique<Node>(name, config_.tx_frames, config_.rx_frames));
  return *nodes_.back();
}

void CanStub::set_faults(const CanFaults& faults) {
  limits_.wire_error = draw_limit(faults.wire_error, "wire_error");
  limits_.loss = draw_limit(faults.loss, "loss");
  limits_.alter = draw_limit(faults.alter, "alter");
  limits_.delay = draw_limit(faults.delay, "delay");
  if (faults.delay_ns < 0 || faults.delay_ns > 60 * rt::kNanosecondsPerSecond)
    throw std::runtime_error("CAN stub: delay_ns lies in 0 to one minute");
  config_.faults = faults;
}

void CanStub::set_plugged(const CanBus& node, bool plugged) noexcept {
  if (Node* found = find(node)) found->plugged = plugged;
}

void CanStub::set_babbling(const CanBus& node, const CanFrame& frame) noexcept {
  if (Node* found = find(node)) {
    found->babbles = can_frame_valid(frame);
    found->babble = frame;
  }
}

CanNodeErrors CanStub::errors(const CanBus& node) const noexcept {
  const Node* found = find(node);
  return found != nullptr ? found->errors : CanNodeErrors{};
}

CanStub::Node* CanStub::find(const CanBus& bus) const noexcept {
  for (const auto& node : nodes_) {
    if (node.get() == &bus) return node.get();
  }
  return nullptr;
}

}  // namespace sortie::drivers
