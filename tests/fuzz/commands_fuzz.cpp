// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: any messages that ask a robot to drive or fly, with and without a key. What was not
// signed with the key is never taken, what is taken comes out of the encoder again byte for byte, and the
// gates take nothing twice, nothing that jumps and nothing that is not finite.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "drivers/wire_cursor.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_requests.hpp"
#include "planner/request_gate.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

using Message = std::span<const std::uint8_t>;
constexpr SipKey kKey{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};

void require(bool condition) {
  if (!condition) std::abort();
}

// True when the last 8 bytes are the tag of those before.
bool is_signed(Message message) {
  if (message.size() < 8) return false;
  std::uint64_t tag = 0;
  std::vector<std::uint8_t> bytes(message.begin(), message.end());
  for (std::size_t i = bytes.size() - 8; i < bytes.size(); ++i) tag = tag << 8 | bytes[i];
  return tag == siphash24(kKey, message.first(message.size() - 8));
}

template <class Request>
void try_request(Message message) {
  Request open;
  Request keyed;
  const Status without = decode(message, nullptr, open);
  const Status with = decode(message, &kKey, keyed);
  require((with == Status::ok) == (without == Status::ok && is_signed(message)));
  if (without != Status::ok) return;
  std::vector<std::uint8_t> again(message.size() + 8);
  std::size_t size = 0;
  require(encode(open, &kKey, again, size) == Status::ok && size == message.size());
  require(std::equal(message.begin(), message.end() - 8, again.begin()));
  require(decode(Message(again).first(size), &kKey, keyed) == Status::ok);
  // One bit of it changed anywhere is somebody else's message.
  const std::size_t bit = (static_cast<std::size_t>(open.counter & 0x7fffffff) * 31) % (8 * size);
  again[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
  require(decode(Message(again).first(size), &kKey, keyed) != Status::ok);
}

template <class T>
T take(const std::uint8_t*& at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

void try_gates(Message bytes) {
  constexpr std::size_t kRow = 1 + 8 + 4 * 8 + 4 + 4;
  planner::RequestGate drive;
  planner::RequestGate fly;
  const planner::RequestRules rules{3, 1000};
  for (std::size_t row = 0; row + kRow <= bytes.size(); row += kRow) {
    const std::uint8_t* at = bytes.data() + row + 1;
    const auto counter = take<std::int64_t>(at);
    double numbers[4];
    for (double& number : numbers) number = take<double>(at);
    rt::DriveRequest request;
    rt::FlyRequest flight;
    // Small steps, too: no fuzzer finds the next counter by itself.
    request.counter = (bytes[row] & 1) != 0 ? counter : drive.newest + (counter & 3);
    flight.counter = (bytes[row] & 1) != 0 ? counter : fly.newest + (counter & 3);
    request.speed_m_s = numbers[0];
    request.turn_rad_s = numbers[1];
    request.mode = flight.mode = take<std::uint32_t>(at);
    request.posture = take<std::int32_t>(at);
    for (int i = 0; i < 3; ++i) flight.p_world_m[i] = numbers[i];
    flight.yaw_rad = numbers[3];
    const auto newest = drive.newest;
    // The first row's bits say how old it is, and whether a stop needs its counter.
    const rt::Nanoseconds now_ns = (bytes[row] & 2) != 0 ? 1001 : 1000;
    const auto order = (bytes[row] & 4) != 0 ? planner::StopOrder::any : planner::StopOrder::rising;
    if (const std::uint32_t rank = planner::stop_rank(request); rank != 0) {
      // Nothing but its mode counts, and it is refused behind a more final one alone, where it has to rise.
      const bool in_turn = request.counter > newest && request.counter - newest <= planner::kMostCounterStep;
      const bool taken = drive.rank <= rank || in_turn;
      require((drive.take(request, rules, now_ns) == Status::ok) == taken);
      require(drive.newest == (in_turn ? request.counter : newest));
    } else if (drive.take(request, rules, now_ns) == Status::ok) {
      require(request.counter > newest && request.counter - newest <= planner::kMostCounterStep);
      require(drive.newest == request.counter && now_ns == 1000);
      require(std::fabs(request.speed_m_s) <= planner::kMostAskedSpeed_m_s);
      require(request.posture >= -1 && request.posture < 3);
      require(drive.take(request, rules, now_ns) != Status::ok);  // played again
    } else {
      require(drive.newest == newest);
    }
    const auto before = fly.newest;
    const bool stops = planner::stop_rank(flight) != 0;
    if (fly.take(flight, rules, now_ns, order) == Status::ok && stops) {
      require(flight.counter > before || (order == planner::StopOrder::any && fly.newest == before));
    } else if (fly.newest != before) {
      require(flight.counter > before && fly.newest == flight.counter && now_ns == 1000);
      for (const double p : flight.p_world_m) require(std::isfinite(p));
      require(std::isfinite(flight.yaw_rad));
      require(fly.take(flight, rules, now_ns, order) != Status::ok);
    } else {
      require(fly.newest == before);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Message bytes(data, size);
  try_request<DriveRequestMessage>(bytes);
  try_request<FlyRequestMessage>(bytes);
  // No fuzzer guesses a fingerprint: an encoded message of its length lends its own.
  std::vector<std::uint8_t> lent(bytes.begin(), bytes.end());
  std::uint8_t own[kDriveRequestBytes + kFlyRequestBytes];
  std::size_t own_size = 0;
  if (encode(DriveRequestMessage{}, nullptr, own, own_size) == Status::ok && lent.size() == own_size) {
    std::copy_n(own, 8, lent.begin());
    try_request<DriveRequestMessage>(lent);
  }
  if (encode(FlyRequestMessage{}, nullptr, own, own_size) == Status::ok && lent.size() == own_size) {
    std::copy_n(own, 8, lent.begin());
    try_request<FlyRequestMessage>(lent);
  }
  try_gates(bytes);
  return 0;
}
