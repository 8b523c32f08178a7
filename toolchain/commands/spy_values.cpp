// SPDX-License-Identifier: BSD-3-Clause
// One reader for each message type.
#include "toolchain/commands/spy_values.hpp"

#include <string>
#include <string_view>

#include "drivers/wire.hpp"
#include "drivers/wire_cursor.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_requests.hpp"
#include "drivers/wire_ssl.hpp"
#include "drivers/wire_truth.hpp"
#include "rt/fields.hpp"

namespace sortie::toolchain {
namespace {

using Message = std::span<const std::uint8_t>;
using Values = std::vector<drivers::NamedValue>;

void add_array(Values& values, const char* name, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    values.push_back({std::string(name) + "[" + std::to_string(i) + "]", numbers[i]});
  }
}

template <class Integer>
void add(Values& values, std::string name, Integer number) {
  values.push_back({std::move(name), static_cast<double>(number)});
}

template <class Sample>
void add_fields(Values& values, const Sample& sample) {
  rt::for_each_scalar(sample, [&values](const char* name, int index, auto scalar) {
    add(values, index < 0 ? std::string(name) : std::string(name) + "[" + std::to_string(index) + "]",
        scalar);
  });
}

template <class Sample>
Status read_numbered(Message message, Values& values) {
  Sample sample;
  std::int64_t seq = 0;
  const Status status = drivers::decode(message, sample, seq);
  add(values, "seq", seq);
  add_fields(values, sample);
  return status;
}

template <class Sample>
Status read_plain(Message message, Values& values) {
  Sample sample;
  const Status status = drivers::decode(message, sample);
  add_fields(values, sample);
  return status;
}

Status read_scan(Message message, Values& values) {
  rt::ScanHeader header;
  std::int64_t seq = 0;
  const Status status = drivers::decode(message, header, {}, seq);
  add(values, "seq", seq);
  add_fields(values, header);
  return status == Status::full ? Status::ok : status;
}

// What each ray was is too much for a table.
template <class Sample>
Status read_ssl(Message message, Values& values) {
  Sample sample;
  std::int64_t seq = 0;
  const Status status = drivers::decode(message, sample, seq);
  add(values, "seq", seq);
  add(values, "stamp_ns", sample.stamp_ns);
  add(values, "number", sample.number);
  add(values, "rays", sample.rays);
  return status;
}

Status read_pose(Message message, Values& values) {
  drivers::PoseMessage pose;
  const Status status = drivers::decode(message, pose);
  add(values, "utime", pose.utime);
  add_array(values, "pos", pose.pos);
  add_array(values, "vel", pose.vel);
  add_array(values, "orientation", pose.orientation);
  add_array(values, "rotation_rate", pose.rotation_rate);
  return status;
}

Status read_named(Message message, Values& values) {
  drivers::FieldsMessage fields;
  const Status status = drivers::decode(message, fields);
  values = std::move(fields.values);
  return status;
}

Status read_tick(Message message, Values& values) {
  rt::JobRecord tick;
  const Status status = drivers::decode(message, tick);
  add(values, "tick", tick.tick);
  add(values, "job", tick.job);
  add(values, "group", tick.group);
  add(values, "verdict", tick.verdict);
  add(values, "level", tick.level);
  add(values, "shed", tick.shed);
  add(values, "cut", tick.cut);
  return status;
}

Status read_timings(Message message, Values& values) {
  drivers::ExecStats stats;
  const Status status = drivers::decode(message, stats);
  for (const drivers::TaskTiming& task : stats.rows) {
    add(values, task.task + ".missed", task.missed);
    add(values, task.task + ".p99_us", task.p99_us);
    add(values, task.task + ".max_us", task.max_us);
  }
  return status;
}

Status read_pools(Message message, Values& values) {
  drivers::PoolStats stats;
  const Status status = drivers::decode(message, stats);
  for (const drivers::PoolUse& pool : stats.rows) {
    add(values, pool.pool + ".used", pool.used);
    add(values, pool.pool + ".capacity", pool.capacity);
    add(values, pool.pool + ".refused", pool.refused);
  }
  return status;
}

Status read_job(Message message, Values& values) {
  drivers::JobTimingRecord timing;
  const Status status = drivers::decode(message, timing);
  add(values, "tick", timing.tick);
  add(values, "group", timing.group);
  return status;
}

Status read_gap(Message message, Values& values) {
  drivers::GapRecord gap;
  const Status status = drivers::decode(message, gap);
  add(values, "tick", gap.tick);
  add(values, "group", gap.group);
  add(values, "lost", gap.lost);
  return status;
}

Status read_event(Message message, Values& values) {
  drivers::EventRecord event;
  const Status status = drivers::decode(message, event);
  add(values, event.kind + " " + event.subject, event.value);
  add(values, "tick", event.tick);
  return status;
}

Status read_header(Message message, Values& values) {
  drivers::LogHeader header;
  const Status status = drivers::decode(message, header);
  add(values, "base_tick_ns", header.base_tick_ns);
  add(values, "epoch_ns", header.epoch_ns);
  return status;
}

Status read_custom(Message message, Values& values) {
  drivers::CustomView sample;
  const Status status = drivers::decode(message, sample);
  add(values, "seq", sample.seq);
  add(values, "stamp_ns", sample.stamp_ns);
  return status;
}

Status read_parameters(Message message, Values& values) {
  drivers::ParametersMessage parameters;
  const Status status = drivers::decode(message, parameters);
  for (const drivers::ParameterInForce& parameter : parameters.parameters)
    values.push_back({parameter.name, parameter.value});
  return status;
}

Status read_contacts(Message message, Values& values) {
  rt::ContactTruth truth;
  const Status status = drivers::decode(message, truth);
  add(values, "stamp_ns", truth.stamp_ns);
  add(values, "contacts", truth.contacts.size());
  add(values, "dropped", truth.dropped);
  for (std::uint32_t part = 0; part < rt::kVehicleParts; ++part)
    add(values, rt::kVehiclePartNames[part], truth.count(static_cast<rt::VehiclePart>(part)));
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    values.push_back({"flipper_asked_rad" + index, truth.flipper_asked_rad[i]});
    values.push_back({"flipper_angle_rad" + index, truth.flipper_angle_rad[i]});
    values.push_back({"flipper_torque_n_m" + index, truth.flipper_torque_n_m[i]});
  }
  return status;
}

Status read_request(Message message, Values& values) {
  drivers::SetParameter request;
  const Status status = drivers::decode(message, nullptr, request);
  add(values, "counter", request.counter);
  values.push_back({std::string(rt::name_of(request.change)), request.change.value});
  return status;
}

Status read_change(Message message, Values& values) {
  rt::ParameterChange change;
  std::int64_t seq = 0;
  const Status status = drivers::decode(message, change, seq);
  add(values, "seq", seq);
  add(values, "stamp_ns", change.stamp_ns);
  values.push_back({std::string(rt::name_of(change)), change.value});
  return status;
}

// Tags are not looked at, for a table commands nobody; who asks, and when, is no figure.
template <class Request>
Status read_asked(Message message, Values& values) {
  Request request;
  const Status status = drivers::decode(message, nullptr, request);
  rt::for_each_scalar(request, [&values](std::string_view name, int, auto number) {
    if (name != "utime" && name != "session" && name != "sender") add(values, std::string(name), number);
  });
  return status;
}

Status read_answers(Message message, Values& values) {
  drivers::AnswersMessage answers;
  const Status status = drivers::decode(message, nullptr, answers);
  add(values, "counter", answers.counter);
  add(values, "keyed", answers.keyed ? 1 : 0);
  for (drivers::NamedValue& value : answers.state) values.push_back(std::move(value));
  return status;
}

struct Reader {
  std::uint64_t fingerprint;
  Status (*read)(Message, Values&);
};

constexpr Reader kReaders[] = {
    {drivers::kFingerprintImu, read_numbered<rt::ImuSample>},
    {drivers::kFingerprintTrack, read_numbered<rt::TrackSample>},
    {drivers::kFingerprintTruth, read_plain<rt::TruthSample>},
    {drivers::kFingerprintContacts, read_contacts},
    {drivers::kFingerprintSegments, read_segments},
    {drivers::kFingerprintLocated, read_numbered<rt::LocatedPose>},
    {drivers::kFingerprintRecognised, read_numbered<rt::RecognisedPlace>},
    {drivers::kFingerprintCan, read_plain<drivers::CanFrame>},
    {drivers::kFingerprintScan, read_scan},
    {drivers::kFingerprintSslCommand, read_ssl<rt::SslCommand>},
    {drivers::kFingerprintSslReturns, read_ssl<rt::SslReturns>},
    {drivers::kFingerprintPose, read_pose},
    {drivers::kFingerprintFields, read_named},
    {drivers::kFingerprintTick, read_tick},
    {drivers::kFingerprintTiming, read_job},
    {drivers::kFingerprintExecStats, read_timings},
    {drivers::kFingerprintPoolStats, read_pools},
    {drivers::kFingerprintGap, read_gap},
    {drivers::kFingerprintHeader, read_header},
    {drivers::kFingerprintEvent, read_event},
    {drivers::kFingerprintCustom, read_custom},
    {drivers::kFingerprintParameters, read_parameters},
    {drivers::kFingerprintSetParameter, read_request},
    {drivers::kFingerprintParameter, read_change},
    {drivers::kFingerprintDriveRequest, read_asked<drivers::DriveRequestMessage>},
    {drivers::kFingerprintFlyRequest, read_asked<drivers::FlyRequestMessage>},
    {drivers::kFingerprintRequestAnswers, read_answers},
};
static_assert(std::size(kReaders) == drivers::kMessageTypes.size(), "a message type has no reader");

}  // namespace

Status read_values(Message message, Values& values) {
  values.clear();
  const std::uint64_t fingerprint = drivers::fingerprint_of(message);
  for (const Reader& reader : kReaders) {
    if (reader.fingerprint != fingerprint) continue;
    const Status status = reader.read(message, values);
    if (status != Status::ok) values.clear();
    return status;
  }
  return Status::not_supported;
}

}  // namespace sortie::toolchain
