// SPDX-License-Identifier: BSD-3-Clause
// The CAN bus in memory while it runs: arbitration, transmission, faults and fault confinement.

#include "drivers/can_stub.hpp"
#include "drivers/can_stub_node.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kPassiveLimit = 128;
constexpr std::uint32_t kBusOffLimit = 256;
constexpr int kRecoveryBits = 128 * 11;
constexpr int kSuspendBits = 8;
// Error classes as Linux defines them in linux/can/error.h.
constexpr std::uint32_t kErrorController = 0x04;
constexpr std::uint32_t kErrorProtocol = 0x08;
constexpr std::uint32_t kErrorBusOff = 0x40;
constexpr std::uint32_t kErrorBusError = 0x80;
constexpr std::uint32_t kErrorRestarted = 0x100;
constexpr std::uint8_t kReceivePassive = 0x10;  // in data[1]
constexpr std::uint8_t kTransmitPassive = 0x20;
constexpr std::uint8_t kErrorActive = 0x40;
constexpr std::uint64_t kKindWireError = 0;
constexpr std::uint64_t kKindLoss = 1;
constexpr std::uint64_t kKindAlter = 33;
constexpr std::uint64_t kKindDelay = 66;

/// A well-mixed number for (seed, transmission, kind): no generator state, so one fault never shifts another.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

CanFrame error_frame(std::uint32_t error_class, rt::Nanoseconds stamp_ns) {
  CanFrame frame;
  frame.stamp_ns = stamp_ns;
  frame.id = error_class;
  frame.size = 8;
  frame.flags = kCanError;
  return frame;
}

}  // namespace

void CanStub::advance(rt::Nanoseconds now_ns) noexcept {
  started_ = true;
  if (now_ns < last_advance_ns_) {
    ++stats_.time_backwards;
    return;
  }
  while (in_flight_ || start_next(now_ns)) {
    if (flight_.end_ns > now_ns) break;
    finish_flight();
  }
  bring_back(now_ns);
  last_advance_ns_ = now_ns;
}

void CanStub::bring_back(rt::Nanoseconds at_ns) noexcept {
  for (const auto& node : nodes_) {
    if (node->recover(at_ns) && config_.report_errors)
      node->put(error_frame(kErrorRestarted, node->off_until_ns));
  }
}

/// A controller that is slow with a frame; its time begins when the frame before is out.
void CanStub::hold_back(Node& node, std::size_t index) noexcept {
  ++node.taken;
  const CanFaults& faults = config_.faults;
  if (limits_.delay == 0 || (node.head.id & faults.id_mask) != faults.id) return;
  const std::uint64_t draw = mix(mix(mix(config_.seed) + node.taken) + kKindDelay + index);
  if ((draw >> 11) >= limits_.delay) return;
  ++stats_.delayed;
  if (node.head_free_ns > node.ready_ns) node.ready_ns = node.head_free_ns;
  node.ready_ns +=
      static_cast<rt::Nanoseconds>(mix(draw) % (static_cast<std::uint64_t>(faults.delay_ns) + 1));
}

void CanStub::report_state(Node& node, bool was_passive) noexcept {
  if (!config_.report_errors || node.error_passive() == was_passive) return;
  CanFrame frame = error_frame(kErrorController, flight_.end_ns);
  frame.data[1] = was_passive                             ? kErrorActive
                  : node.errors.transmit >= kPassiveLimit ? kTransmitPassive
                                                          : kReceivePassive;
  node.put(frame);
}

rt::Nanoseconds CanStub::acknowledged_from(const Node& sender) const noexcept {
  rt::Nanoseconds t = Node::kForever;
  for (const auto& node : nodes_) {
    if (node.get() != &sender && node->plugged && node->off_until_ns < t) t = node->off_until_ns;
  }
  return t;
}

rt::Nanoseconds CanStub::earliest_start(const Node& node) const noexcept {
  if (!node.plugged || !node.has_head) return Node::kForever;
  // What could have started before the last advance() has started then.
  rt::Nanoseconds t = bus_free_ns_ > last_advance_ns_ ? bus_free_ns_ : last_advance_ns_;
  for (const rt::Nanoseconds limit : {node.ready_ns, node.not_before_ns, node.off_until_ns}) {
    if (limit > t) t = limit;
  }
  return t;
}

CanStub::Node* CanStub::arbitrate(rt::Nanoseconds& start_ns) noexcept {
  start_ns = Node::kForever;
  for (const auto& node : nodes_) {
    rt::Nanoseconds t = earliest_start(*node);
    if (t == Node::kForever) continue;
    const rt::Nanoseconds heard = acknowledged_from(*node);
    if (heard > t) {  // a real controller repeats the frame until somebody answers; nothing else can happen
      if (!node->unacknowledged) ++stats_.unacknowledged;
      node->unacknowledged = true;
      if (node->errors.transmit < kPassiveLimit) node->errors.transmit = kPassiveLimit;
      t = heard;
    }
    if (t < start_ns) start_ns = t;
  }
  if (start_ns == Node::kForever) return nullptr;
  Node* winner = nullptr;
  std::uint32_t best = 0;
  bool tie = false;
  for (const auto& node : nodes_) {
    if (earliest_start(*node) > start_ns) continue;
    const std::uint32_t key = can_arbitration_key(node->head);
    if (winner != nullptr && key > best) continue;
    tie = winner != nullptr && key == best;
    if (!tie) winner = node.get();
    best = key;
  }
  if (tie) ++stats_.collisions;
  return winner;
}

bool CanStub::start_next(rt::Nanoseconds now_ns) noexcept {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i]->take_up(last_advance_ns_, now_ns)) hold_back(*nodes_[i], i);
  }
  rt::Nanoseconds start_ns = 0;
  Node* winner = arbitrate(start_ns);
  // A frame queued later may still be ready at exactly now_ns, so nothing starts at now_ns itself.
  if (winner == nullptr || start_ns >= now_ns) return false;
  bring_back(start_ns);
  ++transmissions_;
  flight_.sender = winner;
  flight_.bits = config_.worst_case_stuffing
                     ? can_frame_bits_worst((winner->head.flags & kCanRemote) != 0 ? 0 : winner->head.size,
                                            (winner->head.flags & kCanExtended) != 0)
                     : can_frame_bits(winner->head);
  std::uint64_t draw = 0;
  flight_.destroyed = struck(limits_.wire_error, winner->head.id, kKindWireError, draw);
  if (flight_.destroyed) {  // somewhere after the base identifier, before the end of frame
    const auto room = static_cast<std::uint64_t>(flight_.bits - 20);
    flight_.bits = 13 + static_cast<int>(mix(draw) % room) + kCanErrorFrameBits;
  }
  flight_.start_ns = start_ns;
  flight_.end_ns = start_ns + flight_.bits * bit_ns_;
  in_flight_ = true;
  return true;
}

void CanStub::finish_flight() noexcept {
  in_flight_ = false;
  bus_free_ns_ = flight_.end_ns + kCanIntermissionBits * bit_ns_;
  stats_.busy_bits += static_cast<std::uint64_t>(flight_.bits + kCanIntermissionBits);
  if (flight_.destroyed) {
    finish_destroyed();
  } else {
    finish_good();
  }
  Node& sender = *flight_.sender;
  if (sender.error_passive()) sender.not_before_ns = bus_free_ns_ + kSuspendBits * bit_ns_;
}

void CanStub::finish_good() noexcept {
  Node& sender = *flight_.sender;
  ++stats_.frames;
  Node::bump(sender.sent);
  const bool was_passive = sender.error_passive();
  if (sender.errors.transmit > 0) --sender.errors.transmit;
  report_state(sender, was_passive);
  sender.has_head = false;
  sender.head_free_ns = flight_.end_ns;
  CanFrame frame = sender.head;
  frame.stamp_ns = flight_.end_ns;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = *nodes_[i];
    if (&node == &sender || !node.active(flight_.start_ns)) continue;
    const bool passive = node.error_passive();
    // ISO 11898-1, 12.1.4.2: from error passive, a good frame leads back to just below it.
    if (node.errors.receive > 0)
      node.errors.receive =
          node.errors.receive >= kPassiveLimit ? kPassiveLimit - 1 : node.errors.receive - 1;
    report_state(node, passive);
    deliver(node, i, frame);
  }
}

void CanStub::finish_destroyed() noexcept {
  Node& sender = *flight_.sender;
  ++stats_.wire_errors;
  for (const auto& node : nodes_) {
    if (!node->active(flight_.start_ns)) continue;
    Node::bump(node->error_frames);
    const bool passive = node->error_passive();
    if (node.get() != &sender && node->errors.receive < kBusOffLimit - 1) ++node->errors.receive;
    if (config_.report_errors) node->put(error_frame(kErrorProtocol | kErrorBusError, flight_.end_ns));
    if (node.get() != &sender) report_state(*node, passive);
  }
  const bool was_passive = sender.error_passive();
  sender.errors.transmit += 8;
  if (sender.errors.transmit < kBusOffLimit) {
    report_state(sender, was_passive);
    return;
  }
  ++stats_.bus_off;
  sender.errors.bus_off = true;
  sender.off_until_ns = config_.bus_off_recovery ? flight_.end_ns + kRecoveryBits * bit_ns_ : Node::kForever;
  if (config_.report_errors) sender.put(error_frame(kErrorBusOff, flight_.end_ns));
  sender.off.store(true, std::memory_order_release);
}

bool CanStub::struck(std::uint64_t limit, std::uint32_t id, std::uint64_t kind,
                     std::uint64_t& draw) const noexcept {
  if (limit == 0 || (id & config_.faults.id_mask) != config_.faults.id) return false;
  draw = mix(mix(mix(config_.seed) + transmissions_) + kind);
  return (draw >> 11) < limit;
}

void CanStub::deliver(Node& to, std::size_t index, CanFrame frame) noexcept {
  std::uint64_t draw = 0;
  if (struck(limits_.loss, frame.id, kKindLoss + index, draw)) {
    ++stats_.lost;
    return;
  }
  const bool has_data = frame.size > 0 && (frame.flags & kCanRemote) == 0;
  if (has_data && struck(limits_.alter, frame.id, kKindAlter + index, draw)) {
    const std::uint64_t bit = mix(draw) % (std::uint64_t{frame.size} * 8);
    frame.data[bit / 8] = static_cast<std::uint8_t>(frame.data[bit / 8] ^ (1u << (bit % 8)));
    ++stats_.altered;
  }
  to.put(frame);
}

}  // namespace sortie::drivers
