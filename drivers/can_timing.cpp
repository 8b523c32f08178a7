// SPDX-License-Identifier: BSD-3-Clause
// Bit-level length and arbitration of CAN frames.
#include "drivers/can_timing.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kBaseIdMax = 0x7FF;
constexpr std::uint32_t kExtendedIdMax = 0x1FFFFFFF;
constexpr int kUnstuffedTailBits = 10;  // CRC delimiter, ACK slot, ACK delimiter, 7 bits end of frame

/// Counts the bits that a transmitter puts on the bus while it computes CRC and stuffing.
class BitMeter {
 public:
  void put(std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) put_bit((value >> i) & 1u);
  }
  void put_crc() { put(crc_, 15); }
  int bits() const { return bits_; }

 private:
  void put_bit(std::uint32_t bit) {
    constexpr std::uint32_t kPolynomial = 0x4599;
    const std::uint32_t feedback = bit ^ ((crc_ >> 14) & 1u);
    crc_ = (crc_ << 1) & 0x7FFFu;
    if (feedback != 0) crc_ ^= kPolynomial;
    ++bits_;
    run_ = bit == last_ ? run_ + 1 : 1;
    last_ = bit;
    if (run_ == 5) {  // the stuff bit is the opposite one and starts a new run
      ++bits_;
      last_ ^= 1u;
      run_ = 1;
    }
  }

  std::uint32_t crc_{0};
  std::uint32_t last_{2};  // neither 0 nor 1: the start of frame begins the first run
  int run_{0};
  int bits_{0};
};

}  // namespace

bool can_frame_valid(const CanFrame& frame) noexcept {
  if ((frame.flags & ~(kCanExtended | kCanRemote)) != 0 || frame.size > 8) return false;
  return frame.id <= ((frame.flags & kCanExtended) != 0 ? kExtendedIdMax : kBaseIdMax);
}

int can_frame_bits(const CanFrame& frame) noexcept {
  const bool remote = (frame.flags & kCanRemote) != 0;
  BitMeter meter;
  meter.put(0, 1);  // start of frame
  if ((frame.flags & kCanExtended) != 0) {
    meter.put(frame.id >> 18, 11);
    meter.put(3, 2);  // SRR, IDE recessive
    meter.put(frame.id & 0x3FFFFu, 18);
    meter.put(remote ? 1 : 0, 1);
    meter.put(0, 2);  // two reserved bits
  } else {
    meter.put(frame.id, 11);
    meter.put(remote ? 1 : 0, 1);
    meter.put(0, 2);  // IDE and one reserved bit
  }
  meter.put(frame.size, 4);
  if (!remote) {
    for (int i = 0; i < frame.size && i < 8; ++i) meter.put(frame.data[i], 8);
  }
  meter.put_crc();
  return meter.bits() + kUnstuffedTailBits;
}

int can_frame_bits_worst(int data_bytes, bool extended) noexcept {
  const int stuffable = (extended ? 54 : 34) + 8 * data_bytes;
  return stuffable + (stuffable - 1) / 4 + kUnstuffedTailBits;
}

std::uint32_t can_arbitration_key(const CanFrame& frame) noexcept {
  const std::uint32_t remote = (frame.flags & kCanRemote) != 0 ? 1 : 0;
  if ((frame.flags & kCanExtended) == 0) return frame.id << 21 | remote << 20;
  return (frame.id >> 18) << 21 | 3u << 19 | (frame.id & 0x3FFFFu) << 1 | remote;
}

}  // namespace sortie::drivers
