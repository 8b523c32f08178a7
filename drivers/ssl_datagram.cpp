// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/ssl_datagram.hpp"

#include <algorithm>

namespace sortie::drivers {

namespace {

// Unsigned: a stamp that is nonsense must not overflow.
rt::Nanoseconds sum_of(rt::Nanoseconds a, rt::Nanoseconds b) {
  return static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}
rt::Nanoseconds difference_of(rt::Nanoseconds a, rt::Nanoseconds b) {
  return static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

// True if `stamp` lies within [arrival - behind, arrival + ahead]. An arrival is a reading of the machine's
// clock, far from the ends of the range; a stamp may be anything.
bool is_in_time(rt::Nanoseconds stamp, rt::Nanoseconds arrival, rt::Nanoseconds behind,
                rt::Nanoseconds ahead) {
  return stamp >= arrival - behind && stamp <= arrival + ahead;
}

bool answers(const rt::SslReturns& returns, const rt::SslCommand& command) {
  return returns.rays == command.rays &&
         std::equal(returns.direction, returns.direction + returns.rays, command.direction);
}

}  // namespace

Status SslDatagram::open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem) {
  config.purpose = LinkPurpose::ssl;
  epoch_ns_ = epoch_ns;
  sent_count_ = 0;
  any_answered_ = false;
  first_ = count_ = 0;
  counters_ = {};
  return link_.open(config, problem);
}

Status SslDatagram::send(const rt::SslCommand& command) noexcept {
  if (!can_be_fired(command)) return Status::out_of_range;
  rt::SslCommand leaving = command;
  leaving.stamp_ns = sum_of(command.stamp_ns, epoch_ns_);
  std::uint8_t payload[kSslCommandBytes];
  std::size_t size = 0;
  Status status = encode(leaving, static_cast<std::int64_t>(sent_count_), payload, size);
  if (status == Status::ok) status = link_.send({payload, size});
  if (status != Status::ok) {
    ++counters_.unsent;
    return status;
  }
  sent_[sent_count_ % kRemembered] = leaving;
  ++sent_count_;
  ++counters_.commands;
  return Status::ok;
}

void SslDatagram::take(std::span<const std::uint8_t> payload, rt::Nanoseconds arrival_ns) noexcept {
  rt::SslReturns returns;
  std::int64_t ignored = 0;
  if (decode(payload, returns, ignored) != Status::ok) {
    ++counters_.malformed;
    return;
  }
  const auto known = static_cast<std::uint32_t>(std::min<std::uint64_t>(sent_count_, kRemembered));
  const rt::SslCommand* command = nullptr;
  for (std::uint32_t i = 0; i < known && command == nullptr; ++i) {
    if (sent_[i].number == returns.number) command = &sent_[i];
  }
  const auto ahead = static_cast<std::int32_t>(returns.number - answered_);
  if (command == nullptr) {
    ++counters_.unasked;
  } else if (any_answered_ && ahead == 0) {
    ++counters_.repeated;
  } else if (any_answered_ && ahead < 0) {
    ++counters_.overtaken;
  } else if (!answers(returns, *command)) {
    ++counters_.mismatched;
  } else if (!is_in_time(returns.stamp_ns, arrival_ns, kMostBehindNs, kMostAheadNs)) {
    ++counters_.out_of_time;
  } else if (count_ == waiting_.size()) {
    ++counters_.overrun;
  } else {
    any_answered_ = true;
    answered_ = returns.number;
    returns.stamp_ns = difference_of(returns.stamp_ns, epoch_ns_);
    waiting_[(first_ + count_++) % waiting_.size()] = returns;
    ++counters_.frames;
  }
}

void SslDatagram::poll() noexcept {
  std::span<const std::uint8_t> payload;
  rt::Nanoseconds stamp_ns = 0;
  for (int i = 0; i < kMostPerPoll && link_.receive(payload, stamp_ns) == Status::ok; ++i)
    take(payload, stamp_ns);
}

Status SslDatagram::receive(rt::SslReturns& returns) noexcept {
  if (count_ == 0) return Status::empty;
  returns = waiting_[first_];
  first_ = (first_ + 1) % static_cast<std::uint32_t>(waiting_.size());
  --count_;
  return Status::ok;
}

Status SslDatagramDevice::open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem) {
  config.purpose = LinkPurpose::ssl;
  epoch_ns_ = epoch_ns;
  life_ = 0;
  any_ = false;
  sent_ = 0;
  counters_ = {};
  return link_.open(config, problem);
}

void SslDatagramDevice::take(std::span<const std::uint8_t> payload, rt::Nanoseconds arrival_ns,
                             SslPort& device) noexcept {
  if (life_ != link_.counters().peers) {
    life_ = link_.counters().peers;
    any_ = false;
  }
  rt::SslCommand command;
  std::int64_t ignored = 0;
  if (decode(payload, command, ignored) != Status::ok) {
    ++counters_.malformed;
  } else if (any_ && static_cast<std::int32_t>(command.number - newest_) <= 0) {
    ++counters_.repeated;
  } else if (!is_in_time(command.stamp_ns, arrival_ns, kMostBehindNs, kMostAheadNs)) {
    ++counters_.out_of_time;
  } else {
    any_ = true;
    newest_ = command.number;
    command.stamp_ns = difference_of(command.stamp_ns, epoch_ns_);
    ++(device.send(command) == Status::ok ? counters_.commands : counters_.refused);
  }
}

void SslDatagramDevice::deliver(SslPort& device) noexcept {
  std::span<const std::uint8_t> payload;
  rt::Nanoseconds stamp_ns = 0;
  for (int i = 0; i < kMostPerPoll && link_.receive(payload, stamp_ns) == Status::ok; ++i)
    take(payload, stamp_ns, device);
}

void SslDatagramDevice::collect(SslPort& device) noexcept {
  rt::SslReturns returns;
  for (int i = 0; i < kMostPerPoll && device.receive(returns) == Status::ok; ++i) {
    returns.stamp_ns = sum_of(returns.stamp_ns, epoch_ns_);
    std::uint8_t payload[kSslReturnsBytes];
    std::size_t size = 0;
    Status status = encode(returns, sent_, payload, size);
    if (status == Status::ok) status = link_.send({payload, size});
    ++(status == Status::ok ? counters_.frames : counters_.unsent);
    if (status == Status::ok) ++sent_;
  }
}

}  // namespace sortie::drivers
