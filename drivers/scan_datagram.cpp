// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/scan_datagram.hpp"

#include <algorithm>
#include <utility>

#include "drivers/wire.hpp"

namespace sortie::drivers {

ScanSender::ScanSender(std::uint32_t capacity) : filling_(capacity), leaving_(capacity) {}

Status ScanSender::open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem) {
  config.purpose = LinkPurpose::scans;
  epoch_ns_ = epoch_ns;
  under_way_ = false;
  counters_ = {};
  return link_.open(config, problem);
}

rt::ScanPoint* ScanSender::reserve(std::uint32_t capacity) noexcept {
  if (open_ || capacity > filling_.size()) {
    ++counters_.refused;
    return nullptr;
  }
  open_ = true;
  return filling_.data();
}

Status ScanSender::commit(const rt::ScanHeader& header) noexcept {
  const bool good = open_ && header.points <= filling_.size();
  open_ = false;
  if (!good) return Status::malformed;
  if (under_way_ || !link_.has_peer()) {
    ++counters_.refused;
    return Status::full;
  }
  std::swap(filling_, leaving_);
  header_ = header;
  header_.stamp_ns += epoch_ns_;
  next_ = 0;
  ++number_;
  under_way_ = true;
  ++counters_.scans;
  return Status::ok;
}

Status ScanSender::send_part() noexcept {
  const std::uint32_t count = std::min(kScanDatagramPoints, header_.points - next_);
  std::uint8_t payload[DatagramLink::kMaxPayload];
  WireWriter writer(payload);
  writer.put(header_.stamp_ns);
  writer.put(number_);
  writer.put(header_.points);
  writer.put(next_);
  writer.put(count);
  writer.put_array(header_.p_world_sensor_m, 3);
  writer.put_array(header_.q_world_sensor, 4);
  writer.put(header_.flags);
  detail::WireOut points{writer};
  for (std::uint32_t i = next_; i < next_ + count; ++i) detail::walk(points, std::as_const(leaving_[i]));
  const Status status = link_.send({payload, points.writer.size()});
  if (status == Status::ok) next_ += count;
  return status;
}

void ScanSender::poll() noexcept {
  std::span<const std::uint8_t> ignored;
  rt::Nanoseconds stamp_ns = 0;
  // A receiver has nothing to say but that it is there.
  for (int i = 0; i < kMostPerPoll && link_.receive(ignored, stamp_ns) == Status::ok; ++i) {
  }
  for (int i = 0; i < kMostPerPoll && under_way_; ++i) {
    const Status status = send_part();
    if (status == Status::full) return;  // the rest later
    if (status != Status::ok) ++counters_.cut;
    under_way_ = status == Status::ok && next_ < header_.points;
  }
}

Status ScanReceiver::open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, ScanSink& sink,
                          std::string& problem) {
  config.purpose = LinkPurpose::scans;
  drop();
  epoch_ns_ = epoch_ns;
  sink_ = &sink;
  known_ = false;
  counters_ = {};
  return link_.open(config, problem);
}

void ScanReceiver::drop() noexcept {
  if (points_ == nullptr) return;
  sink_->cancel();
  points_ = nullptr;
}

void ScanReceiver::begin(const Part& part) noexcept {
  if (points_ != nullptr) {
    ++counters_.incomplete;
    drop();
  }
  known_ = true;
  number_ = part.number;
  next_ = 0;
  header_ = part.header;
  if (part.first != 0) {
    ++counters_.incomplete;
    return;
  }
  points_ = sink_->reserve(part.header.points);
  if (points_ == nullptr) ++counters_.refused;
}

void ScanReceiver::take(std::span<const std::uint8_t> payload) noexcept {
  WireReader reader(payload);
  Part part;
  // Unsigned: a stamp that is nonsense must not overflow.
  part.header.stamp_ns =
      static_cast<rt::Nanoseconds>(reader.get<std::uint64_t>() - static_cast<std::uint64_t>(epoch_ns_));
  part.number = reader.get<std::uint32_t>();
  part.header.points = reader.get<std::uint32_t>();
  part.first = reader.get<std::uint32_t>();
  part.count = reader.get<std::uint32_t>();
  reader.get_array(part.header.p_world_sensor_m, 3);
  reader.get_array(part.header.q_world_sensor, 4);
  part.header.flags = reader.get<std::uint32_t>();
  if (reader.status() != Status::ok || part.count > kScanDatagramPoints ||
      reader.left() != part.count * kScanDatagramPoint || part.count > part.header.points ||
      part.first > part.header.points - part.count) {
    ++counters_.malformed;
    return;
  }
  if (!known_ || part.number != number_ || part.header.stamp_ns != header_.stamp_ns) begin(part);
  if (points_ == nullptr) return;  // of a scan that was given up
  if (part.first != next_ || part.header.points != header_.points) {
    ++counters_.incomplete;
    drop();
    return;
  }
  detail::WireIn points{reader};
  for (std::uint32_t i = 0; i < part.count; ++i) detail::walk(points, points_[next_ + i]);
  next_ += part.count;
  if (next_ < header_.points) return;
  points_ = nullptr;  // handed on, whatever the sink makes of it
  if (sink_->commit(header_) == Status::ok) {
    ++counters_.scans;
  } else {
    ++counters_.refused;
  }
}

void ScanReceiver::poll() noexcept {
  std::span<const std::uint8_t> payload;
  rt::Nanoseconds stamp_ns = 0;
  for (int i = 0; i < kMostPerPoll && link_.receive(payload, stamp_ns) == Status::ok; ++i) take(payload);
}

}  // namespace sortie::drivers
