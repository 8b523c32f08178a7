// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/ugv_ssl.hpp"

#include <algorithm>
#include <tuple>

#include "drivers/wire_ssl.hpp"
#include "firmware_like/vehicles/units.hpp"

namespace sortie::firmware {

SensorMount read_ssl_mount(Profile& profile) {
  return read_mount(profile, "ssl", 0.2, "place of the solid-state lidar on the body",
                    "turn of the solid-state lidar on the body");
}

UgvSsl::UgvSsl(VehicleBuilder& builder) {
  static_cast<void>(read_ssl_mount(builder.profile()));
  rays_ = static_cast<std::uint32_t>(
      builder.profile().integer("ssl.rays", {200, 1, rt::kSslMaxRays, "", "asked for at every release"}));
  const rt::GroupId group = builder.group("ssl", 10);
  std::tie(returns_, port_) = builder.stream<rt::SslReturns>(group, std::string(drivers::kChannelSsl), 8, 4);
  outlet_ = builder.outlet<rt::SslCommand>("ssl", 4);
  const rt::TaskBase* task = builder.task<SslOutput>(group, "ssl", TaskDefaults{100, rt::Criticality::b},
                                                     [this](rt::JobContext& context, SslOutput& output) {
                                                       for (const rt::SslReturns& returns : *returns_)
                                                         take(returns, output);
                                                       rt::SslCommand command;
                                                       stride_.next(rays_, context.due_ns, command);
                                                       output.asked = command.number;
                                                       outlet_->put(command, context.due_ns);
                                                     });
  builder.remembers(task, stride_, newest_);
  builder.counter("ssl_commands_sent", [this] { return static_cast<std::uint64_t>(commands_sent_); });
  builder.counter("ssl_commands_refused", [this] { return commands_refused_; });
}

void UgvSsl::take(const rt::SslReturns& returns, SslOutput& output) {
  if (returns.number > output.asked || returns.number <= output.answered) {
    ++output.unasked;
    return;
  }
  newest_ = returns;
  output.stamp_ns = returns.stamp_ns;
  output.answered = returns.number;
  ++output.frames;
  output.rays += returns.rays;
  output.range_sum_mm = 0;
  output.nearest_mm = 0;
  output.oldest_10us = 0;
  for (std::uint32_t i = 0; i < returns.rays; ++i) {
    const std::uint32_t range_mm = returns.range_mm[i];
    output.oldest_10us = std::max(output.oldest_10us, std::uint32_t{returns.age_10us[i]});
    if (range_mm == 0) continue;
    ++output.returns;
    output.range_sum_mm += range_mm;
    if (output.nearest_mm == 0 || range_mm < output.nearest_mm) output.nearest_mm = range_mm;
  }
}

void UgvSsl::poll(const Devices& devices, rt::Nanoseconds now_ns) {
  rt::SslCommand command;
  while (outlet_->take(now_ns, command)) {
    if (devices.ssl == nullptr || devices.ssl->send(command) != Status::ok) {
      ++commands_refused_;
      continue;
    }
    if (devices.log != nullptr) {
      std::uint8_t message[drivers::kSslCommandBytes];
      std::size_t size = 0;
      if (drivers::encode(command, commands_sent_, message, size) == Status::ok)
        devices.log->sample(std::string(drivers::kChannelSslCommand), now_ns, {message, size});
    }
    ++commands_sent_;
  }
  if (devices.ssl == nullptr) return;
  rt::SslReturns returns;
  // A full stream counts its refusals.
  for (int taken = 0; taken < 8 && devices.ssl->receive(returns) == Status::ok; ++taken)
    static_cast<void>(port_->push(returns, now_ns));
}

}  // namespace sortie::firmware
