// SPDX-License-Identifier: BSD-3-Clause
// What `sortie spy` has seen of each channel, and how it is shown.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/wire_telemetry.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

/// Arrival of one channel's messages. Times are UTC nanoseconds of the receiving computer.
struct ChannelStatistics {
  std::uint64_t fingerprint{};  ///< of the latest message; 0 if it was shorter than eight bytes
  std::uint64_t count{};
  std::uint64_t bytes{};
  std::uint64_t undecodable{};  ///< the type is known, the bytes do not fit it
  std::size_t last_bytes{};
  rt::Nanoseconds first_ns{};
  rt::Nanoseconds last_ns{};
  rt::Nanoseconds max_gap_ns{};
  double interval_mean_s{};
  double interval_square_sum{};             ///< of deviations from the mean, s^2
  std::vector<drivers::NamedValue> values;  ///< of the latest message that could be decoded

  /// Mean rate between the first and the latest message; 0 with fewer than two.
  [[nodiscard]] double rate_hz() const;
  /// Standard deviation of the interval between messages.
  [[nodiscard]] double jitter_s() const;
};

/// One row a channel. At most kMaxChannels rows: a stranger that invents names costs no more than that.
class SpyTable {
 public:
  static constexpr std::size_t kMaxChannels = 512;

  /// `with_values`: keep the numbers of each channel's latest message.
  explicit SpyTable(bool with_values) : with_values_(with_values) {}

  /// Takes one message in. Messages on a new channel beyond kMaxChannels are counted and dropped.
  void add(std::string_view channel, std::span<const std::uint8_t> message, rt::Nanoseconds stamp_ns);

  /// Rows in alphabetical order; names hold any bytes a sender chose.
  [[nodiscard]] const std::map<std::string, ChannelStatistics, std::less<>>& channels() const {
    return channels_;
  }
  /// Messages dropped because the table was full.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

  /// Prints the table, at most `rows` lines of it (0: all). Bytes that could steer a terminal are shown as
  /// '?'.
  void print(std::ostream& out, rt::Nanoseconds now_ns, std::size_t rows = 0) const;
  /// Array of one object a channel.
  [[nodiscard]] firmware::Json to_json(rt::Nanoseconds now_ns) const;

 private:
  bool with_values_;
  std::uint64_t dropped_{};
  std::map<std::string, ChannelStatistics, std::less<>> channels_;
};

/// Name of the type ("imu_t"), or the fingerprint in hex.
std::string shown_type(std::uint64_t fingerprint);

}  // namespace sortie::toolchain
