// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can_datagram.hpp"

#include "drivers/can_timing.hpp"
#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

Status CanDatagram::open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem) {
  config.purpose = LinkPurpose::can;
  epoch_ns_ = epoch_ns;
  counters_ = {};
  return link_.open(config, problem);
}

Status CanDatagram::send(const CanFrame& frame) noexcept {
  if (!can_frame_valid(frame)) return Status::malformed;
  std::uint8_t payload[kPayload];
  WireWriter writer(payload);
  writer.put(frame.id);
  writer.put(frame.size);
  writer.put(frame.flags);
  writer.put_array(frame.data, 8);
  return link_.send(payload);
}

Status CanDatagram::receive(CanFrame& frame) noexcept {
  std::span<const std::uint8_t> payload;
  rt::Nanoseconds stamp_ns = 0;
  for (int i = 0; i < DatagramLink::kMostRefusedPerCall; ++i) {
    if (const Status status = link_.receive(payload, stamp_ns); status != Status::ok) return status;
    WireReader reader(payload);
    CanFrame read;
    read.id = reader.get<std::uint32_t>();
    read.size = reader.get<std::uint8_t>();
    read.flags = reader.get<std::uint8_t>();
    reader.get_array(read.data, 8);
    read.stamp_ns = stamp_ns - epoch_ns_;
    if (reader.finish() == Status::ok && can_frame_valid(read)) {
      frame = read;
      return Status::ok;
    }
    ++counters_.malformed;
  }
  return Status::empty;
}

CanCounters CanDatagram::counters() const noexcept {
  const DatagramLinkCounters& link = link_.counters();
  CanCounters counters;
  counters.sent = link.sent - link.greetings_sent;
  counters.received = link.data - counters_.malformed;
  counters.tx_refused = link.send_refused;
  counters.rx_overrun = link.lost;
  return counters;
}

}  // namespace sortie::drivers
