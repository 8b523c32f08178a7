// SPDX-License-Identifier: BSD-3-Clause
// The sending thread around liblcm. liblcm locks and calls the kernel, so nothing else ever touches it.
#include "drivers/lcm_publisher.hpp"

#include <lcm/lcm.h>

#include <chrono>
#include <cstring>
#include <system_error>
#include <thread>

#include "rt/posix/clock.hpp"
#include "rt/posix/realtime.hpp"

namespace sortie::drivers {

struct LcmPublisher::Network {
  lcm_t* lcm{};
  std::atomic<bool> stop{false};
  std::thread thread;
};

namespace {

// Messages wait at most this long; 500 idle wake-ups a second cost about 0.1 % of a core.
constexpr std::chrono::milliseconds kPoll{2};

// Empty, or what is wrong with the address. liblcm ends the process on some of them.
std::string check_url(const std::string& url) {
  if (url.starts_with("file://") || url.starts_with("memq://")) return {};
  if (url.starts_with("tcpq://")) return "LCM address \"" + url + "\": tcpq:// is not supported; use udpm://";
  try {
    parse_udpm_url(url);
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

}  // namespace

LcmPublisher::LcmPublisher(const LcmPublisherConfig& config) : config_(config) {
  if (config.url == "none" || config.url.empty()) return;
  problem_ = check_url(config.url);
  if (!problem_.empty()) return;

  const std::uint32_t slots = std::bit_ceil(config.slots);
  bytes_ = std::make_unique<std::uint8_t[]>(slots * config.slot_bytes);
  free_slots_ = std::make_unique<std::uint32_t[]>(slots);
  ready_slots_ = std::make_unique<Ready[]>(slots);
  bool fits = free_.attach(free_slots_.get(), slots) && ready_.attach(ready_slots_.get(), slots);
  for (std::uint32_t slot = 0; fits && slot < slots; ++slot) fits = free_.try_push(slot);

  network_ = std::make_unique<Network>();
  network_->lcm = fits ? lcm_create(config.url.c_str()) : nullptr;
  if (network_->lcm == nullptr) {
    problem_ =
        "LCM address \"" + config.url +
        "\" cannot be opened; telemetry is off (is multicast allowed here? `ip route` shows where it goes)";
    return;
  }
  try {
    network_->thread = std::thread([this] {
      // A thread inherits its creator's real-time priority; this one must never compete with a task.
      static_cast<void>(rt::posix::set_ordinary_priority());
      rt::posix::set_thread_name("lcm-publisher");
      while (!network_->stop.load(std::memory_order_acquire)) {
        send_waiting();
        cpu_ns_.store(rt::posix::thread_cpu_now(), std::memory_order_relaxed);
        std::this_thread::sleep_for(kPoll);
      }
      send_waiting();
    });
    active_ = true;
  } catch (const std::system_error& error) {
    problem_ = std::string("the LCM thread cannot be started: ") + error.what() + "; telemetry is off";
  }
}

LcmPublisher::~LcmPublisher() {
  if (network_ == nullptr) return;
  network_->stop.store(true, std::memory_order_release);
  if (network_->thread.joinable()) network_->thread.join();
  if (network_->lcm != nullptr) lcm_destroy(network_->lcm);
}

Status LcmPublisher::reserve(std::string_view channel, std::span<std::uint8_t>& slot) noexcept {
  if (!active_) return Status::disconnected;
  if (channel.empty() || channel.size() > kMaxChannelLength || channel.find('\0') != std::string_view::npos) {
    refused_.add();
    return Status::malformed;
  }
  if (!have_reserved_ && !free_.try_pop(reserved_)) {
    dropped_.add();
    return Status::full;
  }
  have_reserved_ = true;
  slot = {bytes_.get() + reserved_ * config_.slot_bytes, config_.slot_bytes};
  return Status::ok;
}

Status LcmPublisher::commit(std::string_view channel, Status encoded, std::size_t size) noexcept {
  if (encoded != Status::ok || size > config_.slot_bytes) {
    refused_.add();  // the slot stays reserved for the next message
    return encoded != Status::ok ? encoded : Status::out_of_range;
  }
  Ready ready;
  ready.slot = reserved_;
  ready.size = static_cast<std::uint32_t>(size);
  std::memcpy(ready.channel, channel.data(), channel.size());
  have_reserved_ = false;
  // Cannot fail: there are as many places as slots.
  return ready_.try_push(ready) ? Status::ok : Status::full;
}

Status LcmPublisher::publish(std::string_view channel, std::span<const std::uint8_t> message) noexcept {
  return publish_encoded(channel, [&message](std::span<std::uint8_t> out, std::size_t& size) {
    if (message.size() > out.size()) return Status::out_of_range;
    if (!message.empty()) std::memcpy(out.data(), message.data(), message.size());
    size = message.size();
    return Status::ok;
  });
}

void LcmPublisher::send_waiting() noexcept {
  Ready ready;
  while (ready_.try_pop(ready)) {
    const std::uint8_t* bytes = bytes_.get() + ready.slot * config_.slot_bytes;
    const bool sent = lcm_publish(network_->lcm, ready.channel, bytes, ready.size) == 0;
    (sent ? published_ : send_errors_).add();
    static_cast<void>(free_.try_push(ready.slot));
  }
}

LcmPublisherCounters LcmPublisher::counters() const noexcept {
  const auto read = [](const Count& count) {
    return std::uint64_t{count.value.load(std::memory_order_relaxed)};
  };
  return {read(published_), read(dropped_), read(refused_), read(send_errors_)};
}

}  // namespace sortie::drivers
