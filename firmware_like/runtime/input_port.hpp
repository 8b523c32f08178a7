// SPDX-License-Identifier: BSD-3-Clause
// The gate between the outside and a stream of the executive: admits a sample, numbers it, and writes it down
// in the log.
//
// The rule: what a log could not hold is not used, be a log kept or not. A sample whose message cannot be
// encoded, or would be refused when it is read back, is refused here and counted; so a message's encode()
// refuses all that its decode() refuses. What the disk then does not take is a GAP in the log, and a replay
// ends before it (firmware_like/log/log_recorder.hpp).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/channels.hpp"
#include "drivers/scan_source.hpp"
#include "drivers/wire.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_ssl.hpp"
#include "firmware_like/runtime/arrivals.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// Takes what was admitted, for the log. Called on the driver's thread, before the sample can be consumed.
class SampleSink {
 public:
  virtual ~SampleSink() = default;
  /// `stamp_ns`: receipt on the run's clock; of a scan its own stamp. The bytes are an LCM message.
  virtual void sample(const std::string& channel, rt::Nanoseconds stamp_ns,
                      std::span<const std::uint8_t> message) = 0;
};

/// A port, whatever its type. One thread at a time.
class InputPortBase {
 public:
  InputPortBase(std::string channel, rt::StreamBase& stream)
      : channel_(std::move(channel)), stream_(stream) {}
  virtual ~InputPortBase() = default;
  InputPortBase(const InputPortBase&) = delete;
  InputPortBase& operator=(const InputPortBase&) = delete;

  /// LCM channel under which samples stand in a log.
  const std::string& channel() const { return channel_; }
  const rt::StreamBase& stream() const { return stream_; }
  void set_sink(SampleSink* sink) { sink_ = sink; }
  /// Replay: admits a recorded message; a replay that is recorded itself writes it down again. Status: ok,
  /// full, malformed (not this type, or damaged), out_of_range (more than a buffer holds).
  Status push_message(std::span<const std::uint8_t> message, rt::Nanoseconds received_ns) {
    arrives(received_ns);
    const Status status = admit(message);
    if (status != Status::ok) return status;
    ++admitted_;
    record(received_ns, message);
    return status;
  }
  /// After the stream's state was restored: goes on with its numbers, which arrivals are looked up by.
  void resume() { admitted_ = static_cast<std::int64_t>(stream_.next_admitted()); }
  /// Samples admitted so far.
  std::int64_t admitted() const { return admitted_; }
  /// From now on the arrival times of the last `capacity` samples are kept. Set-up only.
  const Arrivals& keep_arrivals(std::uint32_t capacity) {
    if (!arrivals_) arrivals_ = std::make_unique<Arrivals>(capacity);
    return *arrivals_;
  }

 protected:
  virtual Status admit(std::span<const std::uint8_t> message) = 0;
  void record(rt::Nanoseconds received_ns, std::span<const std::uint8_t> message) {
    if (sink_ != nullptr) sink_->sample(channel_, received_ns, message);
  }
  bool recording() const { return sink_ != nullptr; }
  /// Before a sample is admitted: whoever consumes it can look its arrival up.
  void arrives(rt::Nanoseconds received_ns) {
    if (arrivals_) arrivals_->note(static_cast<std::uint64_t>(admitted_), received_ns);
  }
  std::int64_t admitted_{};

 private:
  std::string channel_;
  rt::StreamBase& stream_;
  SampleSink* sink_{};
  std::unique_ptr<Arrivals> arrivals_;
};

/// Samples that have a message type of their own.
template <class T>
concept HasWireType = requires(const T& value, T& out, std::int64_t seq, std::span<std::uint8_t> bytes,
                               std::size_t& size) {
  drivers::encode(value, seq, bytes, size);
  drivers::decode(std::span<const std::uint8_t>{}, out, seq);
};

/// Port of plain samples. Types without a message of their own travel as custom_t: any described struct will
/// do, if its first field is `stamp_ns`.
template <rt::Described T>
class InputPort final : public InputPortBase {
 public:
  InputPort(std::string channel, rt::Stream<T>& stream)
      : InputPortBase(std::move(channel), stream), stream_(stream) {
    T value{};
    rt::for_each_scalar(value, [this](const char* name, int index, auto scalar) {
      if (!fields_.empty()) fields_ += ",";
      fields_ += name;
      if (index >= 0) fields_ += "[" + std::to_string(index) + "]";
      fields_ += std::is_floating_point_v<decltype(scalar)> ? ":f"
                 : std::is_signed_v<decltype(scalar)>       ? ":i"
                                                            : ":u";
      fields_ += std::to_string(8 * sizeof(scalar));
    });
    message_.resize(128 + fields_.size() + drivers::kMaxChannelLength + 1 + rt::canonical_size<T>());
  }

  /// Admits one sample received at `received_ns` of the run's clock. Status: ok; full, or what encode() says
  /// of a sample that no log could hold (refused and counted; then it is not in the log either).
  Status push(const T& sample, rt::Nanoseconds received_ns) {
    // Asked once: a consumer that made room between two questions would take what the log does not hold.
    if (!stream_.has_room()) return stream_.refuse();
    std::size_t size = 0;
    if (const Status status = encode(sample, size); status != Status::ok) {
      static_cast<void>(stream_.refuse());  // counts it
      return status;
    }
    record(received_ns, {message_.data(), size});
    arrives(received_ns);
    const Status status = stream_.push(sample);  // only this thread fills the ring, so there still is room
    if (status == Status::ok) ++admitted_;
    return status;
  }

 private:
  Status admit(std::span<const std::uint8_t> message) override {
    T sample{};
    if constexpr (HasWireType<T>) {
      std::int64_t seq = 0;
      if (const Status status = drivers::decode(message, sample, seq); status != Status::ok)
        return Status::malformed;
    } else {
      drivers::CustomView view;
      if (const Status status = drivers::decode(message, view); status != Status::ok)
        return Status::malformed;
      if (view.fields != fields_ || view.data.size() != rt::canonical_size<T>()) return Status::malformed;
      rt::decode_canonical(view.data.data(), sample);
    }
    return stream_.push(sample);
  }

  Status encode(const T& sample, std::size_t& size) {
    if constexpr (HasWireType<T>) {
      return drivers::encode(sample, admitted_, message_, size);
    } else {
      std::uint8_t canonical[rt::canonical_size<T>()];
      rt::encode_canonical(sample, canonical);
      const drivers::CustomView view{channel(), sample.stamp_ns, admitted_, fields_, canonical};
      return drivers::encode(view, message_, size);
    }
  }

  rt::Stream<T>& stream_;
  std::string fields_;
  std::vector<std::uint8_t> message_;
};

/// Stream of scans, as the mapping tasks see it.
using ScanStream = rt::PooledStream<rt::ScanHeader, rt::ScanPoint>;

/// Port of scans: a lidar driver writes straight into the pooled buffer.
class ScanPort final : public InputPortBase, public drivers::ScanSink {
 public:
  ScanPort(std::string channel, ScanStream& stream)
      : InputPortBase(std::move(channel), stream),
        stream_(stream),
        message_(drivers::scan_bytes(stream.slot_size())) {}

  rt::ScanPoint* reserve(std::uint32_t capacity) noexcept override {
    return points_ = stream_.reserve(capacity);
  }

  Status commit(const rt::ScanHeader& header) noexcept override {
    if (points_ == nullptr || header.points > stream_.slot_size()) {
      stream_.cancel();
      return Status::malformed;
    }
    if (recording()) {
      std::size_t size = 0;
      const rt::PointScan scan{header, points_};
      // There is room for as many points as a buffer holds.
      static_cast<void>(drivers::encode(scan, admitted_, message_, size));
      record(header.stamp_ns, {message_.data(), size});
    }
    points_ = nullptr;
    arrives(header.stamp_ns);
    const Status status = stream_.commit(header);
    if (status == Status::ok) ++admitted_;
    return status;
  }

  void cancel() noexcept override {
    stream_.cancel();
    points_ = nullptr;
  }

 private:
  Status admit(std::span<const std::uint8_t> message) override {
    rt::ScanHeader header;
    std::int64_t seq = 0;
    // Asked for without room first: the header says how many points there are.
    Status status = drivers::decode(message, header, {}, seq);
    if (status != Status::full && status != Status::ok) return Status::malformed;
    if (header.points > stream_.slot_size()) return Status::out_of_range;
    rt::ScanPoint* points = stream_.reserve(header.points);
    if (points == nullptr) return Status::full;
    status = drivers::decode(message, header, {points, header.points}, seq);
    if (status != Status::ok) {
      stream_.cancel();
      return Status::malformed;
    }
    return stream_.commit(header);
  }

  ScanStream& stream_;
  rt::ScanPoint* points_{};
  std::vector<std::uint8_t> message_;
};

}  // namespace sortie::firmware
