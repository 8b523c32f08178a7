// SPDX-License-Identifier: BSD-3-Clause
// A lidar that sends its turns in datagrams, as lidars do, from one process of a machine to another.
//
// Payload, big endian: i64 stamp, u32 number of the scan, u32 points in it, u32 index of the first point
// here, u32 points here, f64[3] place and f64[4] attitude of the sensor, u32 flags, then the points: f32 x,
// y, z, u16 intensity, u16 age.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/datagram_link.hpp"
#include "drivers/scan_source.hpp"
#include "rt/describe.hpp"

namespace sortie::drivers {

/// Bytes before the points of a datagram, and points that one can hold.
inline constexpr std::size_t kScanDatagramHead = 8 + 4 * 4 + 7 * 8 + 4;
inline constexpr std::size_t kScanDatagramPoint = 16;
inline constexpr std::uint32_t kScanDatagramPoints =
    static_cast<std::uint32_t>((DatagramLink::kMaxPayload - kScanDatagramHead) / kScanDatagramPoint);

/// What a sender has done.
struct ScanSenderCounters {
  std::uint64_t scans{};  ///< taken over, to be sent
  std::uint64_t
      refused{};        ///< nobody there, no room for so many points, or the scan before was still on its way
  std::uint64_t cut{};  ///< given up on the way: the receiver left
  SORTIE_FIELDS(scans, refused, cut)
};

/// The lidar's end: a sink that a lidar model writes into. A turn is taken over when it is committed and sent
/// by poll(), a few datagrams at a time, while the next one is filled. Two buffers of `capacity` points,
/// taken at construction. One thread.
class ScanSender final : public ScanSink {
 public:
  /// Datagrams that one call of poll() sends: 64 kB a millisecond, so that no receiver's buffer overflows.
  static constexpr int kMostPerPoll = 8;

  explicit ScanSender(std::uint32_t capacity);

  /// `epoch_ns` is added to the stamps of all scans: they leave on CLOCK_MONOTONIC. Status and `problem` as
  /// DatagramLink::open(); this end listens.
  [[nodiscard]] Status open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem);

  [[nodiscard]] rt::ScanPoint* reserve(std::uint32_t capacity) noexcept override;
  [[nodiscard]] Status commit(const rt::ScanHeader& header) noexcept override;
  void cancel() noexcept override { open_ = false; }

  /// Listens for the receiver and sends what is due. About every millisecond.
  void poll() noexcept;

  const DatagramLink& link() const noexcept { return link_; }
  const ScanSenderCounters& counters() const noexcept { return counters_; }

 private:
  Status send_part() noexcept;

  DatagramLink link_;
  rt::Nanoseconds epoch_ns_{};
  std::vector<rt::ScanPoint> filling_;
  std::vector<rt::ScanPoint> leaving_;
  bool open_{};  ///< a reservation
  bool under_way_{};
  rt::ScanHeader header_{};  ///< of what is leaving
  std::uint32_t next_{};     ///< its first point that has not left
  std::uint32_t number_{};
  ScanSenderCounters counters_{};
};

/// What a receiver has seen.
struct ScanReceiverCounters {
  std::uint64_t scans{};       ///< whole, handed on
  std::uint64_t incomplete{};  ///< a datagram of them was lost: dropped
  std::uint64_t refused{};     ///< not taken by the sink
  std::uint64_t malformed{};   ///< datagrams that cannot be part of a scan
  SORTIE_FIELDS(scans, incomplete, refused, malformed)
};

/// The runtime's end: the driver of such a lidar. Points are written where the sink says, once; a scan is
/// handed on when all of it has come. No heap, nothing blocks. One thread.
class ScanReceiver {
 public:
  static constexpr int kMostPerPoll = 64;

  /// Status and `problem` as DatagramLink::open(). `sink` outlives the receiver; stamps count from
  /// `epoch_ns` of CLOCK_MONOTONIC.
  [[nodiscard]] Status open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, ScanSink& sink,
                            std::string& problem);
  ~ScanReceiver() { drop(); }
  ScanReceiver() = default;
  ScanReceiver(const ScanReceiver&) = delete;
  ScanReceiver& operator=(const ScanReceiver&) = delete;

  /// Takes what has come, at most 64 datagrams. About every millisecond, on the thread of the sink.
  void poll() noexcept;

  const DatagramLink& link() const noexcept { return link_; }
  const ScanReceiverCounters& counters() const noexcept { return counters_; }

 private:
  struct Part {
    rt::ScanHeader header{};
    std::uint32_t number{};
    std::uint32_t first{};
    std::uint32_t count{};
  };
  void take(std::span<const std::uint8_t> payload) noexcept;
  void begin(const Part& part) noexcept;
  void drop() noexcept;

  DatagramLink link_;
  rt::Nanoseconds epoch_ns_{};
  ScanSink* sink_{};
  rt::ScanPoint* points_{};  ///< of the scan that is coming in, null if there is none
  rt::ScanHeader header_{};
  std::uint32_t number_{};
  bool known_{};          ///< `number_` is of the newest scan that was begun
  std::uint32_t next_{};  ///< point that must come next
  ScanReceiverCounters counters_{};
};

}  // namespace sortie::drivers
